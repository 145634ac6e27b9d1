"""An orthonormal basis of many rows and few columns, quickly."""

from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray

NEARLY_DEPENDENT: Final = 1e-6
"""Share of a column that the others do not hold, below which Cholesky is not used [-]."""


def orthonormal(columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an orthonormal basis of columns, and the triangular factor.

    Twice Cholesky's factor of the products, which is as orthonormal as Householder's and
    several times as fast; Householder's where the columns are nearly dependent.

    Parameters
    ----------
    columns : (n_rows, n_columns) array
        Of length 1 [-].

    Returns
    -------
    q : (n_rows, n_columns) array
        Orthonormal [-].
    r : (n_columns, n_columns) array
        Upper triangular, ``columns = q @ r`` [-].

    References
    ----------
    .. [1] Y. Yamamoto, Y. Nakatsukasa, Y. Yanagisawa and T. Fukaya, "Roundoff error analysis
       of the CholeskyQR2 algorithm", Electronic Trans. Numerical Analysis 44, 306-326, 2015.
    """
    found = _by_cholesky(columns)
    if found is not None:
        return found
    q, r = scipy.linalg.qr(columns, mode="economic", check_finite=False)
    diagonal = np.abs(np.diag(r))
    filled = r + np.diag(np.where(diagonal < 1e-13, 1e-13, 0.0))
    return np.asarray(q, dtype=np.float64), np.asarray(filled, dtype=np.float64)


def _by_cholesky(columns: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Return basis and factor, None where the columns are nearly dependent."""
    try:
        first = np.asarray(np.linalg.cholesky(columns.T @ columns).T, dtype=np.float64)
        if np.min(np.diag(first), initial=1.0) < NEARLY_DEPENDENT:
            return None
        rough = np.asarray(columns @ _inverse(first), dtype=np.float64)
        second = np.asarray(np.linalg.cholesky(rough.T @ rough).T, dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    return np.asarray(rough @ _inverse(second)), np.asarray(second @ first)


def _inverse(triangular: FloatArray) -> FloatArray:
    """Return the inverse of an upper triangular matrix."""
    return np.asarray(scipy.linalg.solve_triangular(triangular, np.eye(triangular.shape[0])))
