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

from collections.abc import Sequence
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
    place : (int, int, int, int)
        The stack of windows it is in, which window of that, the first of its residuals, and
        the first that is not.
    """

    test: int
    gram: FloatArray
    pull: FloatArray
    place: tuple[int, int, int, int] = (0, 0, 0, 0)


def covariance(
    inverse: FloatArray, blocks: Sequence[Cluster], each: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of numbers, and by how much their bounds are wider.

    The scatter is that over blocks: a sandwich whose slopes of the cost are those that each
    block would have if it had taken no part in the fit (the jackknife, CR3 in [1]_), for one
    that rules the fit has next to no residual of its own in it.

    Parameters
    ----------
    inverse : (n, n) array
        Of the information of all.
    blocks : sequence of Cluster
        All of them.
    each : (n_blocks, n) array
        The step that each of them makes (see `without_each`).

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
    found: FloatArray = each.T @ each * max(len(each) - 1, 1) / len(each)
    untold = np.diag(inverse) > UNTOLD**2
    found[untold, untold] = np.maximum(found[untold, untold], np.diag(inverse)[untold])
    square, expected = _between_tests(_root(inverse), blocks)
    within, between = freedom_of(each**2), freedom_of(expected)
    ratio = square / np.maximum(np.diag(found), np.finfo(float).tiny)
    disagree = scipy.special.fdtrc(between, within, ratio) < BY_CHANCE
    wider = np.where(disagree, np.sqrt(ratio) * wider_by(between), wider_by(within))
    return found, wider


def without_each(
    inverse: FloatArray, blocks: Sequence[Cluster]
) -> tuple[FloatArray, FloatArray]:
    r"""Return the step that each block makes, and the largest share that it has in a direction.

    .. math:: A^{-1} (I - G A^{-1})^{-1} p = R (I - R^T G R)^{-1} R^T p, \qquad A^{-1} = R R^T

    Without the block the numbers were that step back, were the residual as straight as its
    slopes. The symmetric form alone can be computed where a direction is told by nothing: the
    other is off by a factor of 500 there. Nothing of what the block tells alone.

    Parameters
    ----------
    inverse : (n, n) array
        Of the information of all.
    blocks : sequence of Cluster
        All of them.

    Returns
    -------
    (n_blocks, n) array
        The steps.
    (n_blocks,) array
        The shares of the information [-].
    """
    root, steps, shares = _root(inverse), [], []
    for own in blocks:
        share, axes = np.linalg.eigh(root.T @ own.gram @ root)
        turned, others = root @ axes, 1.0 - share
        lifted = np.where(others > LEAST_LEFT, 1.0 / np.maximum(others, LEAST_LEFT), 0.0)
        steps.append(turned @ (lifted * (turned.T @ own.pull)))
        shares.append(share[-1])
    return np.array(steps), np.array(shares)


def _root(inverse: FloatArray) -> FloatArray:
    power, directions = np.linalg.eigh(0.5 * (inverse + inverse.T))
    return np.asarray(directions * np.sqrt(np.maximum(power, 0.0)))


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
