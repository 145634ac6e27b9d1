"""Settings and result of a modal analysis: modes with their intervals."""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.modal_model import ModalFit
from shakerproc.modal.shapes import phase_collinearity
from shakerproc.modal.stabilisation import Diagram, damping_of, frequency_of

NORMAL_95: Final = 1.959964
"""Half-width of a 95 % interval in standard deviations [-]."""

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
