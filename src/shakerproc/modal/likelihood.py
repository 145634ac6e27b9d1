"""Maximum-likelihood refinement of poles and residues on the lines of a record."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.lines import Lines
from shakerproc.modal.modal_model import (
    RESIDUAL_POWERS,
    ModalFit,
    basis_of,
    reference_of,
    rest_of,
    slopes_of,
    stacked,
)

NEARLY_DEPENDENT: Final = 1e-6
"""Share of a column that the others do not hold, below which Cholesky is not used [-]."""

STEPS: Final = 25
"""Steps of the search at most."""

SETTLED: Final = 1e-3
"""Change of the log likelihood below which the search ends."""

DAMPING_LIMITS: Final = (1e-5, 0.3)
"""Where the search keeps damping ratios [-]."""


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
    factors = _by_cholesky(columns)
    if factors is not None:
        return factors
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


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Linear:
    """The best residues for given poles."""

    q: FloatArray  # (2 n_lines, n_columns) orthonormal
    coefficients: FloatArray  # (n_columns, n_outputs)
    residual: FloatArray  # (n_outputs, 2 n_lines), weighted
    noise: FloatArray
    deviance: float
    scaled: FloatArray  # coefficients of columns of length 1
    inverse: FloatArray  # (n_columns, n_columns) of the triangular factor of these columns


def fit(lines: Lines, poles: ComplexArray, steps: int = STEPS) -> ModalFit:
    r"""Return the modal model of greatest likelihood that a search from some poles finds.

    .. math:: Y_o = \sum_m \left( \frac{r_{mo}^T U + t_{mo} D_m}{i\omega - \lambda_m}
        + \ldots^* \right) + \sum_k c_{ok} (i\omega)^k U

    with a noise of its own size on every output. Residues, transients and residual terms are
    linear and eliminated (variable projection, Kaufman's slope); the poles are searched for
    by Levenberg and Marquardt. The covariance is that of Huber and White over lines: it holds
    where the noise is coloured or shared by the sensors.

    Parameters
    ----------
    lines : Lines
        What is fitted.
    poles : (n_modes,) complex array
        Where the search begins [rad/s].
    steps : int
        How many at most; 0 fits the residues only.

    Returns
    -------
    Fit
        Poles sorted by frequency.

    References
    ----------
    .. [1] M. El-Kafafy, P. Guillaume and B. Peeters, "Modal parameter estimation by combining
       stochastic and deterministic frequency-domain approaches", Mechanical Systems and Signal
       Processing 35, 52-68, 2013.
    .. [2] G. H. Golub and V. Pereyra, "Separable nonlinear least squares: the variable
       projection method and its applications", Inverse Problems 19, R1-R26, 2003.
    .. [3] H. White, "A heteroskedasticity-consistent covariance matrix estimator",
       Econometrica 48, 817-838, 1980.
    """
    rest, target = rest_of(lines), stacked(lines.weights * lines.outputs)
    place = _places(np.asarray(poles, dtype=np.complex128))
    linear = _linear(lines, _poles(place), rest, target)
    damping, converged = 1e-3, steps == 0
    for _ in range(steps if place.size else 0):
        _, gram, gradient = _normal_equations(lines, _poles(place), linear)
        lower = None
        while lower is None and damping < 1e6:
            # Marquardt's scaling: damping ratios are known far worse than frequencies
            step = np.linalg.solve(gram + damping * np.diag(np.diag(gram)), -gradient)
            new = np.asarray(place + _limited(np.reshape(step, (2, -1))), dtype=np.float64)
            new[0] = np.clip(new[0], *np.log(DAMPING_LIMITS))
            trial = _linear(lines, _poles(new), rest, target)
            if trial.deviance < linear.deviance:
                lower = new, trial
            else:
                damping *= 8.0
        gain = 0.0 if lower is None else linear.deviance - lower[1].deviance
        if lower is not None:
            (place, linear), damping = lower, max(damping / 8.0, 1e-9)
        if gain < SETTLED:
            converged = True
            break
    return _result(lines, place, linear, converged=converged)


def _places(poles: ComplexArray) -> FloatArray:
    """Return ln(damping ratio) and ln(natural frequency), (2, n_modes)."""
    ratio = np.clip(-poles.real / np.abs(poles), *DAMPING_LIMITS)
    return np.asarray(np.log(np.stack([ratio, np.abs(poles)])))


def _poles(place: FloatArray) -> ComplexArray:
    ratio, omega = np.exp(place)
    return np.asarray(omega * (-ratio + 1j * np.sqrt(1.0 - ratio**2)))


def _limited(step: FloatArray) -> FloatArray:
    """Return a step that changes no damping by more than a factor of 2, nor a frequency 2 %."""
    # logarithms of both: ln 2 is 0.7
    largest = max(float(np.max(np.abs(step[0]))) / 0.7, float(np.max(np.abs(step[1]))) / 0.02)
    return step / max(1.0, largest)


def _linear(lines: Lines, poles: ComplexArray, rest: FloatArray, target: FloatArray) -> _Linear:
    basis = basis_of(lines, poles, rest)
    matrix = np.concatenate([basis.columns.reshape(-1, target.shape[1]), rest])
    scale = np.linalg.norm(matrix, axis=1)
    scale[scale == 0.0] = 1.0
    q, r = orthonormal((matrix / scale[:, np.newaxis]).T)
    shared = q.T @ target.T
    scaled = scipy.linalg.solve_triangular(r, shared)
    residual = target - (q @ shared).T
    noise = np.maximum(
        2.0 * np.mean(residual**2, axis=1), 1e-24 * np.mean(target**2, axis=1) + 1e-300
    )
    n = target.shape[1]
    inverse = scipy.linalg.solve_triangular(r, np.eye(r.shape[0]))
    return _Linear(
        q=q,
        coefficients=scaled / scale[:, np.newaxis],
        residual=residual,
        noise=noise,
        deviance=float(n * np.sum(np.log(noise))),
        scaled=scaled,
        inverse=inverse,
    )


def _losses(linear: _Linear, n_modes: int, n_columns: int) -> FloatArray:
    """Return how much the deviance rises without each mode, its neighbours adapted."""
    n = linear.residual.shape[1]
    losses = np.empty(n_modes)
    for mode in range(n_modes):
        columns = slice(mode * n_columns, (mode + 1) * n_columns)
        # (A A^T)^-1 by the singular values of A: columns of a blow's response and of what rang
        # before it are nearly dependent, and their products singular
        turned, sizes, _ = np.linalg.svd(linear.inverse[columns], full_matrices=False)
        least = np.finfo(np.float64).eps * sizes.max()
        along = turned.T @ linear.scaled[columns] / np.maximum(sizes, least)[:, np.newaxis]
        more = np.sum(along**2, axis=0)
        losses[mode] = n * np.sum(np.log1p(2.0 * more / n / linear.noise))
    return losses


def _normal_equations(
    lines: Lines, poles: ComplexArray, linear: _Linear
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return slopes off the columns (n_modes, 2, n_columns, 2 n_lines), Gram and gradient.

    Those are over ln(damping ratio) of all modes, then ln(natural frequency).
    """
    real, imaginary = slopes_of(lines, poles)
    n_modes, n_columns, n_rows = real.shape
    omega, ratio = np.abs(poles), -poles.real / np.abs(poles)
    root = np.sqrt(1.0 - ratio**2)
    along_ratio = (
        -(omega * ratio)[:, np.newaxis, np.newaxis] * real
        - (omega * ratio**2 / root)[:, np.newaxis, np.newaxis] * imaginary
    )
    along_omega = (
        poles.real[:, np.newaxis, np.newaxis] * real
        + poles.imag[:, np.newaxis, np.newaxis] * imaginary
    )
    flat = np.stack([along_ratio, along_omega]).reshape(-1, n_rows)
    flat -= (flat @ linear.q) @ linear.q.T
    products = (flat @ flat.T).reshape(2, n_modes, n_columns, 2, n_modes, n_columns)
    residues = linear.coefficients[: n_modes * n_columns].reshape(n_modes, n_columns, -1)
    weight = 1.0 / linear.noise
    gram = np.einsum(
        "amibnj,mio,njo,o->ambn", products, residues, residues, weight, optimize=True
    )
    against = (flat @ linear.residual.T).reshape(2, n_modes, n_columns, -1)
    gradient = -np.einsum("amio,mio,o->am", against, residues, weight)
    size = 2 * n_modes
    slopes = flat.reshape(2, n_modes, n_columns, n_rows)
    return slopes, gram.reshape(size, size), gradient.reshape(size)


def _covariance(lines: Lines, poles: ComplexArray, linear: _Linear) -> FloatArray:
    """Return the covariance of the searched parameters.

    That of white noise, enlarged where the scores of the lines scatter more (coloured noise,
    noise that the sensors share, what the model does not explain): a line is counted with
    what its own fit has taken off it (HC2).
    """
    slopes, gram, _ = _normal_equations(lines, poles, linear)
    n_modes, n_columns = slopes.shape[1:3]
    residues = linear.coefficients[: n_modes * n_columns].reshape(n_modes, n_columns, -1)
    n_rows = linear.residual.shape[1]
    # leverage of a line (MacKinnon and White, J. Econometrics 29, 305-325, 1985)
    taken = np.minimum(np.sum(linear.q**2, axis=1), 0.9)
    weighted = linear.residual / linear.noise[:, np.newaxis] / np.sqrt(1.0 - taken)
    mixed = np.einsum("mio,or->mir", residues, weighted)
    each = np.einsum("amir,mir->amr", slopes, mixed).reshape(2 * n_modes, n_rows)
    scores = each[:, : n_rows // 2] + each[:, n_rows // 2 :]
    inverse = np.linalg.pinv(gram, hermitian=True)
    free = n_rows / max(n_rows - linear.q.shape[1], 1)
    plain = 0.5 * free * inverse  # the noise is that of a complex line, rows have half of it
    robust = inverse @ (scores @ scores.T) @ inverse
    return _enlarged(plain, robust)


def _enlarged(plain: FloatArray, robust: FloatArray) -> FloatArray:
    """Return the first covariance, scaled up where the second has larger variances."""
    ratio = np.diag(robust) / np.where(np.diag(plain) > 0.0, np.diag(plain), 1.0)
    scale = np.sqrt(np.maximum(ratio, 1.0))
    return plain * scale * scale[:, np.newaxis]


def _power(outputs: ComplexArray) -> FloatArray:
    """Return the mean square of each output over the lines, 1 where it is 0."""
    power = np.mean(np.abs(outputs) ** 2, axis=1)
    return np.where(power > 0.0, power, 1.0)


def _result(lines: Lines, place: FloatArray, linear: _Linear, *, converged: bool) -> ModalFit:
    poles = _poles(place)
    n_modes, n_lines = poles.size, lines.frequency.size
    n_inputs = lines.inputs.shape[0]
    n_columns = 2 * (n_inputs + lines.n_transients)
    n_outputs = lines.outputs.shape[0]
    pole_coefficients = linear.coefficients[: n_modes * n_columns].reshape(
        n_modes, n_columns, n_outputs
    )
    halves = pole_coefficients[:, : 2 * n_inputs].reshape(n_modes, n_inputs, 2, n_outputs)
    residues = np.moveaxis(halves[:, :, 0] + 1j * halves[:, :, 1], 1, 2)
    covariance = (_covariance(lines, poles, linear) if n_modes else np.zeros((0, 0))).reshape(
        2, n_modes, 2, n_modes
    )
    by_frequency = np.argsort(np.abs(poles))
    covariance = covariance[:, by_frequency][..., by_frequency]
    residual = linear.residual[:, :n_lines] + 1j * linear.residual[:, n_lines:]
    n_rest = n_inputs * len(RESIDUAL_POWERS)
    rest = linear.coefficients[n_modes * n_columns :][:n_rest]
    return ModalFit(
        poles=poles[by_frequency],
        residues=residues[by_frequency],
        rest=np.moveaxis(rest.reshape(n_inputs, len(RESIDUAL_POWERS), n_outputs), 0, 1),
        reference=reference_of(lines),
        covariance=covariance.transpose(1, 0, 3, 2).reshape(2 * n_modes, 2 * n_modes),
        synthesis=lines.outputs - residual / lines.weights,
        noise=linear.noise,
        unexplained=np.sqrt(
            _power(np.asarray(residual / lines.weights, dtype=np.complex128))
            / _power(lines.outputs)
        ),
        deviance=linear.deviance,
        losses=_losses(linear, n_modes, n_columns)[by_frequency],
        n_parameters=2 * n_modes + linear.q.shape[1] * lines.outputs.shape[0],
        converged=converged,
    )
