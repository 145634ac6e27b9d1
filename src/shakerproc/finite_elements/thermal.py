"""How the clearance of a joint changes with temperature."""

from dataclasses import dataclass
from typing import final

from shakerproc import checks


@final
@dataclass(frozen=True, slots=True)
class ThermalFit:
    """An opening with an insert in it: a hole and a bushing, a slot and a pin.

    Attributes
    ----------
    opening, insert : float
        Sizes along the axis of the play, at the reference temperature [m].
    opening_expansion, insert_expansion : float
        Linear coefficients of thermal expansion of the two materials [1/K].
    """

    opening: float
    insert: float
    opening_expansion: float
    insert_expansion: float

    def __post_init__(self) -> None:
        checks.positive("opening", self.opening, "m")
        checks.positive("insert", self.insert, "m")
        checks.finite("opening_expansion", self.opening_expansion, "1/K")
        checks.finite("insert_expansion", self.insert_expansion, "1/K")


@final
@dataclass(frozen=True, slots=True)
class Clearances:
    """Free play to either side of where the insert rests, below 0 where it is squeezed.

    They are the parameters of the effect ``offset_gap``; where both are equal, of ``gap``.

    Attributes
    ----------
    positive, negative : float
        Along the axis and against it [m].
    """

    positive: float
    negative: float

    @property
    def play(self) -> float:
        """Opening less insert [m]."""
        return self.positive + self.negative


def clearances_at(
    fit: ThermalFit,
    temperature_change: float,
    *,
    span: float = 0.0,
    span_expansion: float = 0.0,
) -> Clearances:
    r"""Return the clearances of a joint at another temperature.

    .. math:: d_o (1 + \alpha_o \Delta T) - d_i (1 + \alpha_i \Delta T)

    is the play, half of it to either side. Where the part is held at another joint a `span`
    away, its opening also moves by :math:`L \, \Delta\alpha \, \Delta T` past the insert: ahead
    of it there is more room by as much as there is less behind. A hole
    grows with its part, however the part is shaped around it.

    Parameters
    ----------
    fit : ThermalFit
        Sizes and materials; the insert is centred at the reference temperature.
    temperature_change : float
        Temperature less that at which the sizes were measured [K].
    span : float
        Distance from the joint that holds the part, along the axis [m].
    span_expansion : float
        Coefficient of the part less that of what it stands on [1/K].

    Returns
    -------
    Clearances
        To either side [m].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       sections 1.2 (why the joints have play) and 8.2 (clearances set by a thermal chamber).
    """
    opening = fit.opening * (1.0 + fit.opening_expansion * temperature_change)
    insert = fit.insert * (1.0 + fit.insert_expansion * temperature_change)
    half, shift = (opening - insert) / 2.0, span * span_expansion * temperature_change
    return Clearances(positive=half + shift, negative=half - shift)


def temperature_change_for(fit: ThermalFit, play: float) -> float:
    """Return the change of temperature at which opening less insert is a given play [K].

    Parameters
    ----------
    fit : ThermalFit
        Sizes and materials.
    play : float
        Wanted play; 0 where the joint just closes [m].

    Raises
    ------
    ValueError
        If the play does not change with temperature.
    """
    rate = fit.opening * fit.opening_expansion - fit.insert * fit.insert_expansion
    if rate == 0.0:
        raise ValueError(
            f"the play is {fit.opening - fit.insert:g} m at every temperature: opening and "
            f"insert expand alike"
        )
    return (play - (fit.opening - fit.insert)) / rate
