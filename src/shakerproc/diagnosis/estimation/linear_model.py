"""The linear model of tests: its numbers, and what it leaves."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.estimation.linear_parameters import Chain
from shakerproc.models import Mode, Model


@final
@dataclass(frozen=True, slots=True)
class LinearNumber:
    """One number of the linear model.

    Attributes
    ----------
    name : str
        For people.
    unit : str
        SI unit of what it stands for.
    value, low, high : float
        Logarithm of a factor on the prior, or the number itself for delays and weights, with
        its 95 % interval.
    deviations : float
        Of the prior, by which it is off [-].
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    deviations: float


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """Linear model on top of which effects are judged.

    Attributes
    ----------
    model : Model
        With fitted stiffness and damping, and further modes.
    chain : Chain
        Gains, delays, weights of the controls.
    own : tuple of LinearNumber
        Stiffness and damping of the model's elements, with their intervals.
    numbers : tuple of LinearNumber
        Every unknown of the fit with its interval.
    left : mapping of str to float
        For each test the rms that the linear model leaves, over that measured, in its band [-].
    unusual : tuple of LinearNumber
        Numbers of the chain of measurement that their priors do not expect.
    """

    model: Model
    chain: Chain
    own: tuple[LinearNumber, ...]
    numbers: tuple[LinearNumber, ...]
    left: dict[str, float]
    unusual: tuple[LinearNumber, ...]

    def with_mode(self, mode: Mode) -> "LinearModel":
        """Return the linear model with one more mode that was found since."""
        return replace(self, model=replace(self.model, modes=(*self.model.modes, mode)))

    def input_of(self, test: Test) -> FloatArray:
        """Return the excitation of the model in a test: its controls, weighted, (n,) array."""
        mean = test.arrays.controls.mean(axis=1, keepdims=True)
        return np.asarray(self.chain.weights @ (test.arrays.controls - mean))

    def recorded(self, outputs: FloatArray, sample_rate: float) -> FloatArray:
        """Return simulated signals after the chain of measurement, an array like them.

        Parameters
        ----------
        outputs : (n_sensors, n) array
            At the samples [SI].
        sample_rate : float
            Samples per second [Hz].
        """
        n = outputs.shape[1]
        frequency = np.fft.rfftfreq(2 * n, 1.0 / sample_rate)
        turn = np.exp(-2j * np.pi * frequency * self.chain.delays[:, np.newaxis])
        spectrum = np.fft.rfft(outputs, 2 * n) * turn * self.chain.gains[:, np.newaxis]
        return np.asarray(np.fft.irfft(spectrum, 2 * n)[:, :n])
