"""Which channels a simulated recording has: those that the log describes, in its places."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, final

from shakerproc.data import ROLE_UNITS, Channel, ChannelUse, Role
from shakerproc.errors import LogError
from shakerproc.models import BASE, Model
from shakerproc.models.model import SENSOR_UNITS
from shakerproc.testlog import Test
from shakerproc.units import from_si, sensitivity

Holds = Literal["base", "force", "sensor", "mass", "nothing"]

_USUAL: Final = {"m/s^2": "g", "1": "m/m"}
"""Unit of a file for an SI unit, where the log says none; SI elsewhere."""


@final
@dataclass(frozen=True, slots=True)
class WrittenChannel:
    """A channel of a simulated recording.

    Attributes
    ----------
    channel : Channel
        As the file names it; its unit is the one that is stored.
    quantity : str
        SI unit of what is measured.
    volts_per_unit : float, optional
        Sensitivity, where the file is to hold volts [V per unit of `quantity`].
    holds : {"base", "force", "sensor", "mass", "nothing"}
        What the samples are.
    source : str
        Name of the sensor or mass.
    """

    channel: Channel
    quantity: str
    volts_per_unit: float | None
    holds: Holds
    source: str = ""


def written_channels(test: Test, model: Model) -> tuple[WrittenChannel, ...]:
    """Return the channels of the recording of a test, in the order of the file.

    Where the log names no channels: two controls (or a force) and the sensors of the model.

    Raises
    ------
    LogError
        If the model does not say what a channel measures.
    """
    uses = test.channels or _usual(model)
    return tuple(_written(test, model, key, use) for key, use in _places(uses))


def _usual(model: Model) -> tuple[ChannelUse, ...]:
    if model.excitation.role not in {"control", "force"}:
        raise LogError(
            f"{model.title}: a rehearsal needs a base or a force that drives the model, not "
            f"{model.excitation.kind}."
        )
    inputs = (
        (ChannelUse("control 1", "control"), ChannelUse("control 2", "control"))
        if model.excitation.on is None
        else (ChannelUse("force", "force"),)
    )
    roles: dict[str, Role] = {"m/s^2": "response", "m": "displacement", "m/s": "velocity"}
    sensors = (
        ChannelUse(name, roles[SENSOR_UNITS[sensor.measures]])
        for name, sensor in model.sensors.items()
    )
    return (*inputs, *sensors)


def _places(uses: Sequence[ChannelUse]) -> list[tuple[str, ChannelUse | None]]:
    """Return name and use of every channel of the file; numbers keep their places."""
    numbered = {use.key: use for use in uses if isinstance(use.key, int)}
    named = iter([use for use in uses if not isinstance(use.key, int)])
    count = max([len(uses), *(int(key) for key in numbered)])
    places: list[tuple[str, ChannelUse | None]] = []
    for number in range(1, count + 1):
        use = numbered.get(number) or next(named, None)
        name = f"channel {number}" if use is None or number in numbered else str(use.key)
        places.append((name, use))
    return places


def _written(test: Test, model: Model, name: str, use: ChannelUse | None) -> WrittenChannel:
    if use is None or use.role in {"ignore", "tachometer"}:
        return WrittenChannel(Channel(name, "V", name, "V"), "V", None, "nothing")
    quantity = model.unit_of(ROLE_UNITS[use.role][0])
    usual = _USUAL.get(quantity, quantity)
    holds, source = _held(test, model, use, quantity)
    if use.sensitivity is not None:
        output, size = sensitivity(use.sensitivity, quantity)
        electrical = Channel(name, output, name, output)
        return WrittenChannel(electrical, quantity, size, holds, source)
    unit = use.unit or test.expect.unit or usual
    if not _converts(quantity, unit):
        unit = usual
    return WrittenChannel(Channel(name, quantity, name, unit), quantity, None, holds, source)


def _converts(quantity: str, unit: str) -> bool:
    try:
        from_si(1.0, quantity, unit)
    except ValueError:
        return False
    return True


def _held(test: Test, model: Model, use: ChannelUse, quantity: str) -> tuple[Holds, str]:
    """Return the quantity of a channel.

    Raises
    ------
    LogError
        If the model does not say it.
    """
    name = use.name or str(use.key)
    on = model.excitation.on
    if use.role == "control":
        return ("base" if on is None else "nothing"), ""
    if use.role == "force" and on is not None:
        return ("force" if use.at in {None, on} else "nothing"), ""
    for known in (name, str(use.key)):
        if known in model.sensors and model.sensor_unit(model.sensors[known]) == quantity:
            return "sensor", known
    if use.role == "response" and use.at == BASE:
        return ("base" if on is None else "nothing"), ""
    if use.at in model.moving and use.role != "force":
        return "mass", str(use.at)
    wanted = f"sensors: {{{name}: {{at: {model.moving[0]}, measures: acceleration}}}}"
    raise LogError(
        f"{test.source}: test {test.id}: the model does not say what channel {name!r} (role "
        f"{use.role}{f', at {use.at}' if use.at else ''}) measures; add it to the model, such "
        f"as {wanted}, or give the channel role: ignore"
    )
