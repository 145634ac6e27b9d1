"""Where a fit of one effect in one joint may start."""

from dataclasses import dataclass
from typing import final

from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models.identification import Values


@final
@dataclass(frozen=True, slots=True)
class Start:
    """Where a fit of one effect in one joint may start.

    Attributes
    ----------
    kind : str
        Key of the effect.
    between : (str, str)
        The joint.
    values : mapping
        Coordinates, fixed words and numbers.
    stiffness, damping : tuple of float
        Relative changes of stiffness and damping of every joint that go with it; 0 where the
        joint has none [-].
    explained : float
        Share of what the linear model leaves that it explains, in units of the noise [-].
    predicted : float
        The same for blocks of samples that took no part in the regression [-].
    t : float
        Mean over standard error of its gains in such blocks [-].
    left : float
        Mean square of what is left, in units of the noise: 1 where all is explained [-].
    kept : bool
        Whether it is worth a fit.
    told : bool
        Whether a regression on the measured motion, which has no mean, sees it at all.
    """

    kind: str
    between: Joint
    values: Values
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    explained: float
    predicted: float
    t: float
    left: float
    kept: bool = True
    told: bool = True

    @property
    def words(self) -> tuple[str, ...]:
        """Words for a variant of the effect, such as its side."""
        return tuple(value for value in self.values.values() if isinstance(value, str))
