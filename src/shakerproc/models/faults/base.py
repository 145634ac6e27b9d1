"""Interface of a measurement fault: a distortion of a signal by sensor or cable."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import Parameter


class AbstractFault(ABC):
    """A fault of the measurement, which no physical effect explains.

    Attributes
    ----------
    kind : str
        Key in `FAULTS` and in model files.
    parameters : mapping of str to Parameter
        Every field, in order.
    formula : str
        What it does to the signal u, in one line.
    signature : str
        What betrays it in measurements, in one sentence.
    """

    __slots__ = ()

    kind: ClassVar[str]
    parameters: ClassVar[Mapping[str, Parameter]]
    formula: ClassVar[str]
    signature: ClassVar[str]

    @abstractmethod
    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        """Return the recorded signal in place of the true one.

        Parameters
        ----------
        samples : (n_samples,) array
            True signal in its SI unit.
        sample_rate : float
            Samples per second [Hz].

        Returns
        -------
        (n_samples,) array
            Recorded signal in the same unit.
        """
