"""Which channels drive a model and which are its sensors."""

from collections.abc import Collection, Sequence
from typing import Final

from shakerproc.data import (
    Channel,
    Recording,
    UnusedChannel,
)
from shakerproc.errors import DiagnosisError, ModelError
from shakerproc.models import BASE, Model, Sensor
from shakerproc.units import near_miss, quoted

NO_SENSOR: Final = "neither drives the model nor is a sensor of it"


def unused_channels(recording: Recording, used: Collection[int]) -> tuple[UnusedChannel, ...]:
    """Return the channels that the model does not need, and those that nobody uses."""
    spare = (c.name for i, c in enumerate(recording.channels) if i not in used)
    return (*(UnusedChannel(name, NO_SENSOR) for name in spare), *recording.unused)


def misplaced(
    recording: Recording, model: Model, inputs: Sequence[int], rows: Sequence[int]
) -> tuple[str, ...]:
    """Return where the log puts channels that the model has elsewhere, a sentence each."""
    wanted = dict.fromkeys(inputs, model.excitation.on or BASE)
    wanted |= {row: sensor.at for row, sensor in zip(rows, model.sensors.values(), strict=True)}
    return tuple(
        _elsewhere(recording.channels[row], place, model.places)
        for row, place in wanted.items()
        if recording.channels[row].at not in {None, "", place}
    )


def _elsewhere(channel: Channel, place: str, places: tuple[str, ...]) -> str:
    found = channel.at or ""
    meant = None if found in places else near_miss(found, places)
    question = f'; did you mean "{meant}"?' if meant else ""
    return (
        f"channel {channel.name}: the log says at: {quoted(found)}, the model {quoted(place)} "
        f"(its places: {', '.join(places)}){question}"
    )


def sensors_of(model: Model) -> dict[str, Sensor]:
    """Return the sensors of a model that sit on its masses.

    Raises
    ------
    ModelError
        If it has none.
    """
    if not model.sensors:
        raise ModelError(
            f"{model.title}: no sensors, so no channel can be compared with the model. Say "
            f"what each measures, such as sensors: {{ch3: {{at: {model.moving[0]}, "
            f"measures: acceleration}}}}."
        )
    return dict(model.sensors)


def sensor_row(recording: Recording, name: str, model: Model) -> int:
    """Return the row of the channel that is a sensor of the model.

    Raises
    ------
    DiagnosisError
        If the recording has none of that name, or its unit is another.
    """
    for i, channel in enumerate(recording.channels):
        if name in {channel.name, channel.source_name}:
            _check_unit(
                recording, channel, model.sensor_unit(model.sensors[name]), f"sensor {name!r}"
            )
            return i
    raise DiagnosisError(
        f"{recording.run}: the model's sensor {name!r} is no channel of the recording, which "
        f"has {_names(recording.channels)}. Give the channel that name in the log "
        f"(name: {name}), or correct sensors in the model."
    )


def check_driven(model: Model) -> None:
    """Pass a model that an input drives, whose whole tests can be predicted.

    Raises
    ------
    DiagnosisError
        If nothing does.
    """
    if model.excitation.role is None:
        raise DiagnosisError(
            f"{model.title}: a free decay has no input, and where its motion begins only a fit "
            "tells, so that there is no free-run error: see compare_decays. Or give what "
            "excites it in the model: {base: acceleration}, say."
        )


def input_rows(recording: Recording, model: Model) -> list[int]:
    """Return the rows of the channels that drive the model; none of a free decay.

    Raises
    ------
    DiagnosisError
        If there is none, or its unit is another.
    """
    on, role, unit = model.excitation.on, model.excitation.role, model.drive_unit
    if role is None:
        return []
    rows = [i for i, c in enumerate(recording.channels) if c.role == role]
    if on is not None and any(recording.channels[i].at == on for i in rows):
        rows = [i for i in rows if recording.channels[i].at == on]
    if not rows:
        what = _DRIVEN[role].format(on)
        raise DiagnosisError(
            f"{recording.run}: in the model {what}, but no channel has the role {role}. Give "
            f"the channel that measures it this role in the log; the recording has "
            f"{_names(recording.channels)}."
        )
    for i in rows:
        _check_unit(recording, recording.channels[i], unit, f"role {role}")
    return rows


_DRIVEN: Final = {
    "control": "the base is driven",
    "force": "a force acts on {}",
    "displacement": "the displacement of {} is imposed",
}


def _check_unit(recording: Recording, channel: Channel, wanted: str, why: str) -> None:
    if channel.unit != wanted:
        raise DiagnosisError(
            f"{recording.run}: channel {channel.name!r} is in {channel.unit or 'no unit'} "
            f"({channel.source_unit or 'the file says none'}), but {why} needs {wanted}. Give "
            f"unit or sensitivity of the channel in the log, or correct the model."
        )


def _names(channels: Sequence[Channel]) -> str:
    return ", ".join(
        f"{c.name} ({c.role or 'no role'}, {c.unit or 'no unit'})" for c in channels
    )
