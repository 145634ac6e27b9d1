"""A fitted modal model, and the response functions that it stands for."""

from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.basis import RESIDUAL_POWERS


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
    settled : bool
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
    settled: bool

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
