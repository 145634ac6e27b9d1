"""Data of a test for modal analysis: inputs and responses, band, samples or blows, places."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import Channel, ChannelUse, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.geometry import Place, Wireframe
from shakerproc.modal.modal_model import ModeSet
from shakerproc.modal.shapes import mac
from shakerproc.modal.struck import Struck, struck_of
from shakerproc.numerals import numeral
from shakerproc.recordings import FAULTS, health, unusable, within
from shakerproc.runs import find_crop, open_test
from shakerproc.runs.roles import NEAR, uses_of
from shakerproc.spectra import Crop
from shakerproc.testlog import Modal, Test, TestLog

SINGLE_FREQUENCIES: Final = ("sine", "stepped sine")
"""Kinds of excitation that tell no modes."""

MUCH_LEFT: Final = 0.3
"""Share of a response that modes leave, from which on it is said [-]."""

ONE_SHAPE: Final = 0.99
"""MAC from which on two shapes are one, as those of one mode in two tests are [-]."""

DEFAULT_BAND: Final = (20.0, 0.42)
"""Band where nobody says one: from so many lines to so much of the sample rate."""


def band_of(recording: Recording, test: Test, wish: Modal) -> tuple[float, float]:
    """Return where modes are looked for [Hz].

    Raises
    ------
    SpectrumError
        If the recording does not reach there.
    """
    nyquist = recording.sample_rate / 2.0
    duration = recording.n_samples / recording.sample_rate
    usual = (DEFAULT_BAND[0] / duration, DEFAULT_BAND[1] * recording.sample_rate)
    said = wish.band or test.processing.band or test.band
    low, high = usual if said is None else said
    if wish.band is not None and high > nyquist:
        raise SpectrumError(
            f"{recording.run}: the band from {low:g} to {high:g} Hz lies outside the data, "
            f"which reach to {nyquist:g} Hz; correct band under modal"
        )
    high = min(high, 0.49 * recording.sample_rate)
    low = max(low, 2.0 / duration)
    if not low < high:
        raise SpectrumError(
            f"{recording.run}: the band from {low:g} to {high:g} Hz is empty; the recording "
            f"holds {numeral(2.0 / duration)} to {nyquist:g} Hz"
        )
    return low, high


def inputs_of(recording: Recording, wish: Modal) -> list[tuple[str, tuple[int, ...]]]:
    """Return name and rows of each input: the mean of the controls, or each force.

    Raises
    ------
    SpectrumError
        If there are none of those that the log wants.
    """
    roles = [channel.role for channel in recording.channels]
    controls = tuple(i for i, role in enumerate(roles) if role == "control")
    forces = tuple(i for i, role in enumerate(roles) if role == "force")
    wanted = wish.inputs or ("control" if controls else "force" if forces else "none")
    if wanted == "none":
        return []
    rows = controls if wanted == "control" else forces
    if not rows:
        raise SpectrumError(
            f"{recording.run}: no channel has the role {wanted}, which modal: {{inputs: "
            f"{wanted}}} asks for; give it to the channel that measures the input"
        )
    if wanted == "control":
        name = " and ".join(recording.channels[i].name for i in rows)
        return [(f"mean of {name}" if len(rows) > 1 else name, rows)]
    return [(recording.channels[i].name, (i,)) for i in rows]


def responses_of(recording: Recording, taken: set[int]) -> list[int]:
    """Return the rows of the responses.

    Raises
    ------
    SpectrumError
        If there are none.
    """
    kinds = {"response", "displacement", "velocity"} | (set() if taken else {"control"})
    rows = [i for i, c in enumerate(recording.channels) if c.role in kinds and i not in taken]
    if not rows:
        raise SpectrumError(
            f"{recording.run}: no channel has the role response; a mode needs at least one"
        )
    return rows


def remarks_of(
    sensors: Sequence[Channel],
    positions: Sequence[Place | None],
    modes: ModeSet,
    *,
    incomplete: bool,
    places: str = "add position: [0 mm, 0 mm, 0 mm] and direction: z to the channels",
    wireframe: Wireframe | None = None,
) -> list[str]:
    """Return the obstacles to more modes, a sentence each; `places` is how to say positions."""
    texts = []
    if incomplete:
        texts.append("the recording was cut short: its complete part was used")
    if len(sensors) == 1:
        texts.append(
            "one response only: modes have no shape, and modes that are close are told apart "
            "by frequency alone; MAC needs two sensors or more"
        )
    without = [
        sensor.name
        for sensor, position in zip(sensors, positions, strict=True)
        if position is None
    ]
    if without and len(sensors) > 1:
        named = ", ".join(without[:6]) + (" and more" if len(without) > 6 else "")
        texts.append(
            f"no position for {named}: shapes are drawn over the sensors' order; {places}"
        )
    elif wireframe is not None and len(sensors) > 1:
        texts += _unmeasured(sensors, positions, wireframe)
    texts += [
        f"modes at {first:.5g} and {second:.5g} Hz have one shape and lie within their widths: "
        "a resonance that a nonlinearity bends looks like two. Compare levels, or say how many "
        f"there are (modal: {{modes: {modes.poles.size - 1}}})"
        for first, second in twins_of(modes)
    ]
    if modes.model is not None and modes.poles.size:
        unexplained = float(np.max(modes.model.unexplained))
        if unexplained > MUCH_LEFT:
            texts.append(
                f"residual rms of up to {unexplained:.0%} of a response: noise, a "
                "nonlinearity or an input that was not measured; look at the coherence"
            )
    if not modes.poles.size:
        texts.append(
            "no pole stays over the orders: no mode found. Look at the coherence, widen the "
            "band, take a longer record, or name poles under modal: {keep: [...]}"
        )
    return texts


def _unmeasured(
    sensors: Sequence[Channel], positions: Sequence[Place | None], wireframe: Wireframe
) -> list[str]:
    """Return the parts of a geometry that no sensor moves, and sensors beside it."""
    sentences = [f"geometry: {note}" for note in wireframe.notes]
    if not wireframe.edges:
        return sentences
    where = np.array([wireframe.nodes[node] for node in wireframe.used])
    seats = np.array(positions, float)
    is_far = np.linalg.norm(where[:, np.newaxis] - seats, axis=-1) > NEAR
    alone = [s.name for s, lost in zip(sensors, is_far.all(axis=0), strict=True) if lost]
    if alone:
        sentences.append(
            f"geometry: {', '.join(alone[:6])} sit at no node of it: drawn without lines"
        )
    if still := int(is_far.all(axis=1).sum()):
        sentences.append(
            f"geometry: {still} of {len(where)} nodes have no sensor: lines to them are drawn "
            f"at rest"
        )
    return sentences


def twins_of(modes: ModeSet) -> list[tuple[float, float]]:
    """Return pairs of frequencies [Hz] of modes that sensors cannot tell from one.

    Parameters
    ----------
    modes : ModeSet
        Modes; those of a single sensor have no shape that could tell.

    Returns
    -------
    list of (float, float)
        Neighbours whose shapes are alike and that lie closer than the wider one's half-power
        width.
    """
    if modes.shapes.shape[1] < 2:
        return []
    same_shape = mac(modes.shapes, modes.shapes) > ONE_SHAPE
    widths = 2.0 * modes.damping * modes.frequency
    return [
        (float(modes.frequency[i]), float(modes.frequency[i + 1]))
        for i in range(modes.poles.size - 1)
        if same_shape[i, i + 1]
        and modes.frequency[i + 1] - modes.frequency[i] < max(widths[i], widths[i + 1])
    ]


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
    flags = within(health(recording), start, stop)
    lost = unusable(flags, start, stop)
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
    others = [flag for flag in flags if flag not in lost and flag.channel in used]
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
    shared: list[tuple[object, ...]] = []
    names: list[str] = []
    units: list[str] = []
    places: list[tuple[Place | None, Place | None]] = []
    rows: list[list[int]] = []
    for one in tests:
        own = []
        each = zip(one.input_names, one.input_units, one.input_places, strict=True)
        for name, unit, place in each:
            key = (name, place, one.test.id if one.struck is not None else None)
            if key not in shared:
                shared.append(key)
                elsewhere = any(name == other[0] for other in shared[:-1])
                names.append(f"{name} of test {one.test.id}" if elsewhere else name)
                units.append(unit)
                places.append(place)
            own.append(shared.index(key))
        rows.append(own)
    samples = []
    for one, own in zip(tests, rows, strict=True):
        full = np.zeros((len(shared), one.inputs.shape[1]))
        full[own] = one.inputs
        samples.append(full)
    return tuple(names), tuple(units), tuple(places), tuple(samples)
