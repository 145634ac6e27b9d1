"""Data of a test for modal analysis: samples or blows, places of sensors and forces."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import Channel, ChannelUse, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.geometry import Place
from shakerproc.modal.choosing import SINGLE_FREQUENCIES, band_of, inputs_of, responses_of
from shakerproc.modal.struck import Struck, struck_of
from shakerproc.recordings import FAULTS, health, unusable, within
from shakerproc.runs import find_crop, open_test
from shakerproc.runs.roles import uses_of
from shakerproc.spectra import Crop
from shakerproc.testlog import Modal, Test, TestLog

APART: Final = "analyse them apart (tracks.csv follows each mode from test to test)"
"""What to do with tests that no one fit can hold."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """A test as the modal analysis takes it.

    Attributes
    ----------
    test : Test
        What the log says.
    run : str
        Name of the recording, for messages.
    sensors : tuple of Channel
        Responses.
    positions, directions : tuple
        Where they sit [m] and measure [-]; None where the log does not say it.
    input_names, input_units : tuple of str
        Names and units of the inputs.
    input_places : tuple
        Position and direction of each force, None where the log does not say them.
    band : (float, float)
        Where modes are looked for [Hz].
    inputs : (n_inputs, n_samples) array
        Samples [unit of the channel].
    responses : (n_responses, n_samples) array
        Samples [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    struck : Struck, optional
        Blows, of a hammer test.
    incomplete : bool
        Whether the recording was cut short.
    sha256 : str
        Of the recording.
    remarks : tuple of str
        What the health checks say of inputs and sensors.
    """

    test: Test
    run: str
    sensors: tuple[Channel, ...]
    positions: tuple[Place | None, ...]
    directions: tuple[Place | None, ...]
    input_names: tuple[str, ...]
    input_units: tuple[str, ...]
    input_places: tuple[tuple[Place | None, Place | None], ...]
    band: tuple[float, float]
    inputs: FloatArray
    responses: FloatArray
    sample_rate: float
    struck: Struck | None
    incomplete: bool
    sha256: str
    remarks: tuple[str, ...] = ()

    @property
    def seats(self) -> list[tuple[str, Place | None, Place | None]]:
        """Name, position and direction of every sensor."""
        names = (sensor.name for sensor in self.sensors)
        return list(zip(names, self.positions, self.directions, strict=True))


def gather(log: TestLog, test: Test, wish: Modal) -> Gathered:
    """Return the data of a test for modal analysis.

    Raises
    ------
    SpectrumError
        If the recording does not allow it.
    """
    with open_test(log, test) as recording:
        try:
            return _gathered(recording, test, wish)
        except ValueError as error:
            raise SpectrumError(f"{recording.run}: {error}") from error


def _gathered(recording: Recording, test: Test, wish: Modal) -> Gathered:
    if test.excitation in SINGLE_FREQUENCIES:
        raise SpectrumError(
            f"{recording.run}: excitation: {test.excitation} reaches single frequencies, which "
            "tell no modes; use random, a sweep or a shock"
        )
    band = band_of(recording, test, wish)
    crop = find_crop(recording, test)
    groups = inputs_of(recording, wish)
    taken = {row for _, rows in groups for row in rows}
    rows = responses_of(recording, taken)
    samples = recording.source.read(recording.rows, crop.start, crop.stop)
    uses = uses_of(recording, test)
    inputs = {recording.channels[row].name for row in taken}
    remarks = _checked(recording, crop, inputs, {recording.channels[row].name for row in rows})
    return Gathered(
        test=test,
        run=recording.run,
        sensors=tuple(recording.channels[row] for row in rows),
        positions=tuple(uses[row].position if uses else None for row in rows),
        directions=tuple(uses[row].direction if uses else None for row in rows),
        input_names=tuple(name for name, _ in groups),
        input_units=tuple(recording.channels[members[0]].unit for _, members in groups),
        input_places=tuple(_place(recording, members, uses) for _, members in groups),
        band=band,
        inputs=_inputs(samples, groups),
        responses=samples[rows],
        sample_rate=recording.sample_rate,
        struck=struck_of(recording, crop, test, rows) if groups and test.struck else None,
        incomplete=recording.incomplete,
        sha256=recording.file.sha256() if recording.file is not None else "",
        remarks=remarks,
    )


def _checked(
    recording: Recording, crop: Crop, inputs: set[str], sensors: set[str]
) -> tuple[str, ...]:
    """Return the findings of the health checks on inputs and sensors in the crop.

    Raises
    ------
    SpectrumError
        If an input did not measure: no response function has a meaning.
    """
    start, stop = (at / recording.sample_rate for at in (crop.start, crop.stop))
    found = within(health(recording), start, stop)
    lost = unusable(found, start, stop)
    for flag in lost:
        if flag.channel in inputs:
            raise SpectrumError(
                f"{recording.run}: input {flag.channel} {FAULTS.get(flag.kind, flag.kind)}. "
                f"{flag.message}"
            )
    dead = tuple(
        f"{flag.channel} {FAULTS.get(flag.kind, flag.kind)}: its modes may be wrong. "
        f"{flag.message}"
        for flag in lost
        if flag.channel in sensors
    )
    used = {"", *inputs, *sensors}
    others = [flag for flag in found if flag not in lost and flag.channel in used]
    return (*dead, *(flag.line for flag in others))


def _place(
    recording: Recording, members: tuple[int, ...], uses: Sequence[ChannelUse]
) -> tuple[Place | None, Place | None]:
    """Return position and direction of a force; the mean of controls acts in no one place."""
    if not uses or recording.channels[members[0]].role != "force":
        return None, None
    return uses[members[0]].position, uses[members[0]].direction


def _inputs(samples: FloatArray, groups: Sequence[tuple[str, tuple[int, ...]]]) -> FloatArray:
    """Return the mean of the channels of each input, (n_inputs, n_samples) array."""
    if not groups:
        return samples[:0]
    return np.stack([samples[list(members)].mean(axis=0) for _, members in groups])


def check_joint_fit(tests: Sequence[Gathered]) -> None:
    """Check that one fit can hold several tests.

    Raises
    ------
    SpectrumError
        If not: which two differ, in what, and what to do.
    """
    first = tests[0]
    for one in tests[1:]:
        both = f"tests {first.test.id} and {one.test.id} cannot be fitted together"
        if not first.input_names or not one.input_names:
            raise SpectrumError(
                f"{both}: where no input was measured each test is a fit of its own; {APART}"
            )
        if first.seats != one.seats:
            differ = sorted({seat[0] for seat in {*first.seats} ^ {*one.seats}})
            raise SpectrumError(
                f"{both}: they have not the same sensors at the same places "
                f"({', '.join(differ)}); {APART}"
            )
        if first.sample_rate != one.sample_rate:
            raise SpectrumError(
                f"{both}: {first.sample_rate:g} and {one.sample_rate:g} samples per second; "
                f"{APART}"
            )
        if (first.struck is None) != (one.struck is None):
            raise SpectrumError(f"{both}: one is struck by a hammer, the other not; {APART}")
        if first.struck is not None and one.struck is not None:
            differs = first.struck.differs(one.struck)
            if differs:
                raise SpectrumError(f"{both}: their blows have not the same {differs}")


def shared_inputs(
    tests: Sequence[Gathered],
) -> tuple[
    tuple[str, ...],
    tuple[str, ...],
    tuple[tuple[Place | None, Place | None], ...],
    tuple[FloatArray, ...],
]:
    """Return the inputs of tests that are fitted together.

    An input is one where name and place are the same; of blows each test has its own.

    Returns
    -------
    names : tuple of str
        With the test behind the name where it acts in several places.
    units : tuple of str
        Of each.
    places : tuple
        Position and direction of each.
    samples : tuple of (n_inputs, n_samples) arrays
        Of each test, 0 where an input does not act [unit of the channel].
    """
    found: list[tuple[object, ...]] = []
    names: list[str] = []
    units: list[str] = []
    places: list[tuple[Place | None, Place | None]] = []
    rows: list[list[int]] = []
    for one in tests:
        own = []
        each = zip(one.input_names, one.input_units, one.input_places, strict=True)
        for name, unit, place in each:
            key = (name, place, one.test.id if one.struck is not None else None)
            if key not in found:
                found.append(key)
                elsewhere = any(name == other[0] for other in found[:-1])
                names.append(f"{name} of test {one.test.id}" if elsewhere else name)
                units.append(unit)
                places.append(place)
            own.append(found.index(key))
        rows.append(own)
    samples = []
    for one, own in zip(tests, rows, strict=True):
        full = np.zeros((len(found), one.inputs.shape[1]))
        full[own] = one.inputs
        samples.append(full)
    return tuple(names), tuple(units), tuple(places), tuple(samples)
