"""Covariance of what was fitted, from the scatter between blocks, and between tests.

References
----------
.. [1] A. C. Cameron and D. L. Miller, "A practitioner's guide to cluster-robust inference",
   Journal of Human Resources 50, 317-372, 2015.
.. [2] F. E. Satterthwaite, "An approximate distribution of estimates of variance components",
   Biometrics Bulletin 2, 110-114, 1946.
.. [3] R. M. Bell and D. F. McCaffrey, "Bias reduction in standard errors for linear regression
   with multi-stage samples", Survey Methodology 28, 169-181, 2002.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray

UNTOLD: Final = 2.0
"""Standard error of a logarithm from which a bound is no bound: a factor of seven [-]."""

BY_CHANCE: Final = 0.05
"""Probability with which tests that agree are taken for tests that do not: that with which an
interval misses [-]."""

ALONE: Final = 0.1
"""Share of the information that other tests hold, up to which one test tells a number alone:
nothing is there that it could disagree with [-]."""


LEAST_LEFT: Final = 1e-9
"""Share of the information that other blocks hold, up to which one block tells a number alone:
next to the rounding of sums [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Information of one block on the numbers.

    Attributes
    ----------
    test : int
        Of which test it is.
    gram : (n, n) array
        Its information.
    pull : (n,) array
        Slopes times residual.
    """

    test: int
    gram: FloatArray
    pull: FloatArray


def covariance(
    inverse: FloatArray, clusters: Iterable[Cluster]
) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of numbers, and by how much their bounds are wider.

    The scatter is that over blocks: a sandwich whose slopes of the cost are those that each
    block would have if it had taken no part in the fit (the jackknife, CR3 in [1]_), for one
    that rules the fit has next to no residual of its own in it.

    Parameters
    ----------
    inverse : (n, n) array
        Of the information of all.
    clusters : iterable of Cluster
        All blocks.

    Returns
    -------
    (n, n) array
        The covariance.
    (n,) array
        By how much a bound of 95 % is wider than that of the normal law, 1 at least. It is that
        of Student's law, its degrees of freedom those of Welch and Satterthwaite [2]_, for a
        number that few blocks tell is less certain than their scatter says. Where tests
        disagree by more than their blocks explain, it is that of the scatter between tests [-].
    """
    blocks = list(clusters)
    root = _root(inverse)
    each = np.array([_left_out(root, own) for own in blocks])
    found: FloatArray = each.T @ each * max(len(each) - 1, 1) / len(each)
    untold = np.diag(inverse) > UNTOLD**2
    found[untold, untold] = np.maximum(found[untold, untold], np.diag(inverse)[untold])
    square, expected = _between_tests(root, blocks)
    within, between = freedom_of(each**2), freedom_of(expected)
    ratio = square / np.maximum(np.diag(found), np.finfo(float).tiny)
    disagree = scipy.special.fdtrc(between, within, ratio) < BY_CHANCE
    wider = np.where(disagree, np.sqrt(ratio) * wider_by(between), wider_by(within))
    return found, wider


def _root(inverse: FloatArray) -> FloatArray:
    r"""Return a root :math:`R` of :math:`A^{-1} = R R^T`, (n, n) array.

    Of numbers over their own sizes: some are logarithms that nothing tells, others delays of
    microseconds.
    """
    size = np.sqrt(np.diag(inverse))
    scaled = inverse / np.outer(size, size)
    power, directions = np.linalg.eigh(0.5 * (scaled + scaled.T))
    return np.asarray(size[:, None] * directions * np.sqrt(np.maximum(power, 0.0)))


def _left_out(root: FloatArray, own: Cluster) -> FloatArray:
    r"""Return the step of the numbers where a block with gram G and pull p is left out, (n,).

    .. math:: A^{-1} (I - G A^{-1})^{-1} p = R (I - R^T G R)^{-1} R^T p, \qquad A^{-1} = R R^T

    The left form is lost to rounding where nothing tells a direction; the symmetric one is
    not. A direction that the block tells alone adds nothing.
    """
    share, axes = np.linalg.eigh(root.T @ own.gram @ root)
    turned, others = root @ axes, 1.0 - share
    lifted = np.where(others > LEAST_LEFT, 1.0 / np.maximum(others, LEAST_LEFT), 0.0)
    return np.asarray(turned @ (lifted * (turned.T @ own.pull)))


def _between_tests(
    root: FloatArray, blocks: Sequence[Cluster]
) -> tuple[FloatArray, FloatArray]:
    """Return the variance of every number between tests, and how much each test adds to it.

    The first from what is left, such that it is right if all blocks scatter alike (CR2 in
    [3]_), (n,) array, and nothing of what one test tells alone; the second from the
    information, relative, (n_tests, n) array.
    """
    alone, expected = [], []
    total = sum(own.gram for own in blocks)
    for test in sorted({own.test for own in blocks}):
        gram = sum(own.gram for own in blocks if own.test == test)
        pull = sum(own.pull for own in blocks if own.test == test)
        share, axes = np.linalg.eigh(root.T @ gram @ root)
        turned = root @ axes
        others = np.einsum("ik,ij,jk->k", turned, total - gram, turned)
        lifted = 1.0 / np.sqrt(np.maximum(1.0 - share, ALONE))
        alone.append(turned @ (np.where(others > ALONE, lifted, 0.0) * (turned.T @ pull)))
        expected.append(turned**2 @ np.clip(share, 0.0, 1.0))
    return np.sum(np.square(alone), axis=0), np.array(expected)


def freedom_of(squares: FloatArray) -> FloatArray:
    """Return degrees of freedom of a sum of squares, by Satterthwaite, (n,) array [-].

    Parameters
    ----------
    squares : (n_blocks, n) array
        What each block adds to the sum.
    """
    most = np.maximum(np.max(squares, axis=0), np.finfo(float).tiny)
    share = squares / most
    parts = np.maximum(np.sum(share**2, axis=0), np.finfo(float).tiny)
    return np.asarray(np.maximum(1.0, share.sum(axis=0) ** 2 / parts))


def wider_by(freedom: float | FloatArray) -> FloatArray:
    """Return bounds of 95 % of Student's law over those of the normal law, (n,) array [-]."""
    return np.asarray(scipy.special.stdtrit(freedom, 0.975) / scipy.special.ndtri(0.975))
