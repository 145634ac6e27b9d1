"""The lowest modes of large sparse matrices."""

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from shakerproc.data import FloatArray


def lowest_modes(
    stiffness: csr_array, mass: csr_array, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return the lowest natural frequencies and their shapes.

    Parameters
    ----------
    stiffness, mass : (n, n) sparse array
        Symmetric, the stiffness of something that is held.
    count : int
        How many.

    Returns
    -------
    frequencies : (count,) array
        Rising [Hz].
    shapes : (n, count) array
        Of modal mass 1.
    """
    # a quarter of the entries, and of the time, of the ordering that eigsh would choose itself
    factors = splu(
        csc_array(stiffness),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    size = mass.shape[0]
    squared, shapes = eigsh(
        stiffness,
        k=count,
        M=mass,
        sigma=0.0,
        OPinv=LinearOperator((size, size), matvec=factors.solve, dtype=np.float64),
        v0=np.ones(size),
    )
    order = np.argsort(squared)
    return np.sqrt(squared[order]) / (2.0 * np.pi), shapes[:, order]
