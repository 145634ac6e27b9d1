"""A modal model and its modes: functions of frequency that it sums, settings, intervals."""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.lines import Lines
from shakerproc.modal.shapes import phase_collinearity
from shakerproc.modal.stabilisation import Diagram, damping_of, frequency_of

NORMAL_95: Final = 1.959964
"""Half-width of a 95 % interval in standard deviations [-]."""

RESIDUAL_POWERS: Final = (-2, -1, 0, 1, 2)
"""Powers of i omega by which modes below and above the band are stood for."""

TRANSIENT_POWERS: Final = (0, 1, 2)
"""Powers of exp(-i omega dt) in the transient of the modes outside the band."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Columns of the linear problem, real parts above imaginary parts.

    Attributes
    ----------
    columns : (n_modes, 2 (n_inputs + n_transients), 2 n_lines) array
        For each mode, real and imaginary part of each residue and of each record's transient.
    rest : (n_rest, 2 n_lines) array
        Residual terms and the transient of modes outside the band.
    """

    columns: FloatArray
    rest: FloatArray


def rest_of(lines: Lines) -> FloatArray:
    """Return the columns that do not depend on the poles, (n_rest, 2 n_lines)."""
    scaled = 1j * lines.frequency / reference_of(lines)
    terms = [one * scaled**power for one in lines.inputs for power in RESIDUAL_POWERS]
    if lines.transient:
        z = np.exp(-2j * np.pi * lines.frequency * lines.interval)
        level = np.sqrt(np.mean(np.abs(lines.outputs) ** 2)) or 1.0
        terms += [level * own * z**power for own in lines.records for power in TRANSIENT_POWERS]
    return stacked(lines.weights * np.array(terms))


def reference_of(lines: Lines) -> float:
    """Return the frequency that the powers of residual terms are relative to [Hz]."""
    return float(np.sqrt(lines.frequency[0] * lines.frequency[-1]))


def basis_of(lines: Lines, poles: ComplexArray, rest: FloatArray) -> Basis:
    """Return the columns for poles [rad/s]."""
    return Basis(_pairs(lines, *_fractions(lines, poles)), rest)


def slopes_of(lines: Lines, poles: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the slopes of the columns of each mode over real and imaginary part of its pole.

    Parameters
    ----------
    lines : Lines
        What is fitted.
    poles : (n_modes,) complex array
        Poles [rad/s].

    Returns
    -------
    (n_modes, n_columns, 2 n_lines) arrays
        Over the real and over the imaginary part [s/rad].
    """
    s = 2j * np.pi * lines.frequency
    p = poles[:, np.newaxis]
    plain, mirrored = 1.0 / (s - p) ** 2, 1.0 / (s - p.conj()) ** 2
    decay = mirrored_decay = None
    if lines.transient:
        dt = lines.interval
        z = np.exp(-s * dt)
        decay = _decay_slope(p, z, dt)
        mirrored_decay = _decay_slope(p.conj(), z, dt)
    real = _pairs(lines, plain, mirrored, decay, mirrored_decay)
    imaginary = _pairs(
        lines,
        1j * plain,
        -1j * mirrored,
        None if decay is None else 1j * decay,
        None if mirrored_decay is None else -1j * mirrored_decay,
    )
    return real, imaginary


def _fractions(
    lines: Lines, poles: ComplexArray
) -> tuple[ComplexArray, ComplexArray, ComplexArray | None, ComplexArray | None]:
    """Return partial fractions of poles and conjugates, and the spectra of their decays."""
    s = 2j * np.pi * lines.frequency
    p = poles[:, np.newaxis]
    plain, mirrored = 1.0 / (s - p), 1.0 / (s - p.conj())
    if not lines.transient:
        return plain, mirrored, None, None
    z = np.exp(-s * lines.interval)
    decay = 1.0 / (1.0 - np.exp(p * lines.interval) * z)
    mirrored_decay = 1.0 / (1.0 - np.exp(p.conj() * lines.interval) * z)
    return plain, mirrored, decay, mirrored_decay


def _decay_slope(poles: ComplexArray, z: ComplexArray, interval: float) -> ComplexArray:
    """Return the slope of a sampled decay's spectrum over its pole."""
    step = np.exp(poles * interval) * z
    return np.asarray(interval * step / (1.0 - step) ** 2)


def _pairs(
    lines: Lines,
    plain: ComplexArray,
    mirrored: ComplexArray,
    decay: ComplexArray | None,
    mirrored_decay: ComplexArray | None,
) -> FloatArray:
    """Return the columns of residues a + ib: a (p + p*) + b i (p - p*), for every input."""
    columns = []
    for one in lines.inputs:
        columns += [one * (plain + mirrored), one * 1j * (plain - mirrored)]
    if decay is not None and mirrored_decay is not None:
        both = decay + mirrored_decay, 1j * (decay - mirrored_decay)
        columns += [own * part for own in lines.records for part in both]
    return stacked(lines.weights * np.stack(columns, axis=1))


def stacked(values: ComplexArray) -> FloatArray:
    """Return real parts, then imaginary parts, along the last axis.

    `values` may be in any unit.
    """
    return np.concatenate([values.real, values.imag], axis=-1)


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModalFit:
    """A modal model of one record.

    Attributes
    ----------
    poles : (n_modes,) complex array
        By frequency [rad/s].
    residues : (n_modes, n_outputs, n_inputs) complex array
        Of the partial fractions [output unit/input unit rad/s].
    rest : (n_powers, n_inputs, n_outputs) array
        Factors of the residual terms, for the powers of `RESIDUAL_POWERS` [output/input].
    reference : float
        Frequency that those powers are relative to [Hz].
    covariance : (2 n_modes, 2 n_modes) array
        Of ln(damping ratio), then ln(natural frequency), mode by mode [-].
    synthesis : (n_outputs, n_lines) complex array
        What the model says of the outputs [unit of the outputs].
    noise : (n_outputs,) array
        Mean square of what it leaves of a weighted line [unit² of the outputs].
    unexplained : (n_outputs,) array
        Rms of what it leaves over the rms of the output, over the lines [-].
    deviance : float
        -2 ln(likelihood) up to a constant.
    losses : (n_modes,) array
        How much it rises without each mode.
    n_parameters : int
        Real numbers that were fitted.
    converged : bool
        Whether the search ended before its last step.
    """

    poles: ComplexArray
    residues: ComplexArray
    rest: FloatArray
    reference: float
    covariance: FloatArray
    synthesis: ComplexArray
    noise: FloatArray
    unexplained: FloatArray
    deviance: float
    losses: FloatArray
    n_parameters: int
    converged: bool

    def criterion(self, n_values: int) -> float:
        """Return Schwarz' criterion, smaller for the better model."""
        return self.deviance + self.n_parameters * float(np.log(n_values))


def response_functions(model: ModalFit, frequency: FloatArray) -> ComplexArray:
    """Return the response functions of a modal model.

    Parameters
    ----------
    model : ModalFit
        The model.
    frequency : (n_frequencies,) array
        Above 0 [Hz].

    Returns
    -------
    (n_outputs, n_inputs, n_frequencies) complex array
        Response functions [output unit/input unit].
    """
    s = 2j * np.pi * frequency
    plain = 1.0 / (s - model.poles[:, np.newaxis])
    mirrored = 1.0 / (s - model.poles.conj()[:, np.newaxis])
    total = np.einsum("moi,mf->oif", model.residues, plain)
    total += np.einsum("moi,mf->oif", model.residues.conj(), mirrored)
    powers = np.array(RESIDUAL_POWERS)[:, np.newaxis]
    terms = (1j * frequency / model.reference) ** powers
    return np.asarray(total + np.einsum("pio,pf->oif", model.rest, terms))


Method: TypeAlias = Literal["input and response spectra", "response functions", "output only"]


@final
@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of a modal analysis that a user may give.

    Attributes
    ----------
    band : (float, float)
        Where modes are looked for [Hz].
    modes : int, optional
        How many there are; by default as many as the measurement needs.
    order : int
        Highest order of the stabilisation diagram.
    keep : tuple of float
        Frequencies near which a pole is kept, whatever the automatic selection says [Hz].
    """

    band: tuple[float, float]
    modes: int | None = None
    order: int = 60
    keep: tuple[float, ...] = ()


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModeSet:
    """Modes of one record.

    Attributes
    ----------
    method : str
        What they were found from.
    poles : (n_modes,) complex array
        By frequency [rad/s].
    frequency, damping : (n_modes,) arrays
        Undamped natural frequencies [Hz] and damping ratios [-].
    frequency_error, damping_error : (n_modes,) arrays
        Standard deviations of their logarithms [-].
    shapes : (n_modes, n_responses) complex array
        Turned to their mean phase, largest component 1 [-].
    participation : (n_modes, n_inputs) complex array
        How strongly each input drives the mode, largest 1 [-].
    collinearity : (n_modes,) array
        Modal phase collinearity, 1 for a real mode [-].
    diagram : Diagram
        Stabilisation diagram.
    model : ModalFit, optional
        The fitted modal model; None where there is none, output only.
    interval_from : str
        What the intervals are made of.
    notes : tuple of str
        What the user should know, a sentence each.
    scatter : (2, n_modes) array, optional
        Standard deviations over the records of ln(frequency) and ln(damping) [-]; None of one.
    """

    method: Method
    poles: ComplexArray
    frequency_error: FloatArray
    damping_error: FloatArray
    shapes: ComplexArray
    participation: ComplexArray
    diagram: Diagram
    model: ModalFit | None
    interval_from: str
    notes: tuple[str, ...] = ()
    scatter: FloatArray | None = None

    @property
    def frequency(self) -> FloatArray:
        """Undamped natural frequencies [Hz]."""
        return frequency_of(self.poles)

    @property
    def damping(self) -> FloatArray:
        """Damping ratios [-]."""
        return damping_of(self.poles)

    @property
    def collinearity(self) -> FloatArray:
        """Modal phase collinearity of each mode [-]."""
        return phase_collinearity(self.shapes)

    @property
    def frequency_bounds(self) -> FloatArray:
        """Limits of the 95 % intervals, (2, n_modes) [Hz]."""
        return _bounds(self.frequency, self.frequency_error)

    @property
    def damping_bounds(self) -> FloatArray:
        """Limits of the 95 % intervals, (2, n_modes) [-]."""
        return _bounds(self.damping, self.damping_error)

    def unexplained(self, n_responses: int) -> FloatArray:
        """Return the unexplained share of each response, the most over the inputs [-]."""
        if self.model is None:
            return np.full(n_responses, np.nan)
        return np.asarray(self.model.unexplained.reshape(n_responses, -1).max(axis=1))


def _bounds(values: FloatArray, errors: FloatArray) -> FloatArray:
    return np.stack([values * np.exp(-NORMAL_95 * errors), values * np.exp(NORMAL_95 * errors)])
