"""Modes of the tests of a log, matched from test to test by frequency and shape, reciprocal."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import Channel, ComplexArray, FloatArray
from shakerproc.geometry import Place, Wireframe
from shakerproc.modal.geometry import Geometry, geometry_of
from shakerproc.modal.modal_model import ModeSet
from shakerproc.modal.shapes import mac
from shakerproc.numerals import numeral
from shakerproc.runs.roles import Place as ChannelPlace
from shakerproc.runs.roles import sense_of
from shakerproc.testlog import Test

MOST_SHIFT: Final = 0.2
"""Relative change of frequency beyond which two modes are never one [-]."""

LEAST_MAC: Final = 0.5
"""MAC below which two modes are never one [-]."""

NARROW_SHIFT: Final = 0.05
"""Relative change of frequency allowed where shapes cannot tell modes apart [-]."""

TELLING: Final = 3
"""Sensors in common from which on shapes tell modes apart."""


@final
@dataclass(frozen=True, slots=True)
class Sighting:
    """A mode of a track in one test.

    Attributes
    ----------
    test : int
        Number of the test, from 0.
    mode : int
        Number of the mode in it, from 0.
    mac : float, optional
        With the shape in the first test of the track, over the sensors in common [-]; None
        where there are fewer than two of these.
    """

    test: int
    mode: int
    mac: float | None


@final
@dataclass(frozen=True, slots=True)
class Track:
    """One mode through the tests.

    Attributes
    ----------
    sightings : tuple of Sighting
        By test.
    """

    sightings: tuple[Sighting, ...]


def tracks_of(sets: Sequence[ModeSet], sensors: Sequence[Sequence[str]]) -> tuple[Track, ...]:
    """Return the modes of several tests, each followed through them.

    Parameters
    ----------
    sets : sequence of ModeSet
        Modes of each test.
    sensors : sequence of sequence of str
        Names of the sensors of each test, in the order of the shapes.

    Returns
    -------
    tuple of Track
        By frequency where first seen.
    """
    tracks: list[list[Sighting]] = []
    for test, modes in enumerate(sets):
        taken = _matched(tracks, sets, sensors, test)
        for mode in range(modes.poles.size):
            if mode in taken:
                track, mac_value = taken[mode]
                tracks[track].append(Sighting(test, mode, mac_value))
            else:
                tracks.append([Sighting(test, mode, 1.0 if len(sensors[test]) > 1 else None)])
    tracks.sort(key=lambda track: sets[track[0].test].frequency[track[0].mode])
    return tuple(Track(tuple(track)) for track in tracks)


def _matched(
    tracks: Sequence[Sequence[Sighting]],
    sets: Sequence[ModeSet],
    sensors: Sequence[Sequence[str]],
    test: int,
) -> dict[int, tuple[int, float | None]]:
    """Return for modes of a test their track and the MAC with its first shape."""
    modes = sets[test]
    if not tracks or not modes.poles.size:
        return {}
    cost = np.full((len(tracks), modes.poles.size), 1e6)
    mac_values: dict[tuple[int, int], float | None] = {}
    for number, track in enumerate(tracks):
        first, last = track[0], track[-1]
        mine, theirs = common(sensors[first.test], sensors[test])
        shift = np.abs(np.log(modes.frequency / sets[last.test].frequency[last.mode]))
        values = None
        if len(mine) > 1:
            shape = sets[first.test].shapes[first.mode][mine]
            values = mac(shape[np.newaxis], modes.shapes[:, theirs])[0]
        for mode in range(modes.poles.size):
            mac_values[number, mode] = None if values is None else float(values[mode])
            cost[number, mode] = _cost(float(shift[mode]), mac_values[number, mode], len(mine))
    rows, columns = scipy.optimize.linear_sum_assignment(cost)
    return {
        int(mode): (int(number), mac_values[int(number), int(mode)])
        for number, mode in zip(rows, columns, strict=True)
        if cost[number, mode] < 1e5
    }


def _cost(shift: float, mac_value: float | None, n_common: int) -> float:
    """Return how unlike two modes are; more than 1e5 where they are never one."""
    if mac_value is None or n_common < TELLING:
        return shift if shift < NARROW_SHIFT else 1e6
    if shift > MOST_SHIFT or mac_value < LEAST_MAC:
        return 1e6
    return (1.0 - mac_value) + shift


def common(first: Sequence[str], second: Sequence[str]) -> tuple[list[int], list[int]]:
    """Return the places of the sensors that two tests share, in the one and in the other."""
    there = {name: i for i, name in enumerate(second)}
    mine = [i for i, name in enumerate(first) if name in there]
    return mine, [there[first[i]] for i in mine]


def mac_over(
    first: ComplexArray, second: ComplexArray, names: tuple[Sequence[str], Sequence[str]]
) -> FloatArray | None:
    """Return the MAC of shapes over the sensors in common; None where there is but one.

    Shapes may be in any unit.
    """
    mine, theirs = common(*names)
    if len(mine) < 2:
        return None
    return mac(first[:, mine], second[:, theirs])


ALIKE: Final = 0.95
"""Least correlation of two functions that are one [-]: a shift of a resonance by a third of its
half-power width, as a sensor's mass makes it, leaves as much."""

LEVEL: Final = 0.1
"""Largest difference of their sizes [-]: sensitivities of a hammer and of a sensor are known to
some per cent each."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Functions:
    """Response functions of a test, measured and synthesised alike.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Within the band [Hz].
    measured, synthesis : (n_responses, n_inputs, n_frequencies) complex array
        H1 of the measurement, and of what the model answers to the same input, both through
        the same window, so that leakage is the same in both [response unit/input unit].
    coherence : (n_responses, n_frequencies) array
        Multiple coherence of the measurement [-].
    """

    frequency: FloatArray
    measured: ComplexArray
    synthesis: ComplexArray
    coherence: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestModes:
    """Modes of one test.

    Attributes
    ----------
    name : str
        Its id, with the name of the log in front where there are two; of several tests that are
        fitted together, the ids.
    test : Test
        What the log says, of the first where several are fitted together.
    sensors : tuple of Channel
        Rows of the shapes.
    positions, directions : tuple
        Where they sit [m] and measure [-]; None where the log does not say it.
    inputs, input_units : tuple of str
        Names and units of the inputs.
    input_places : tuple
        Position and direction of each force, None where the log does not say them, or where
        the input is the mean of controls.
    band : (float, float)
        Where modes were looked for [Hz].
    modes : ModeSet
        What was found.
    functions : Functions, optional
        None where no input was measured.
    density : (n_responses + 1, n_frequencies) array
        Frequencies of the band [Hz] first, then densities of the responses [unit²/Hz].
    unexplained : (n_responses,) array
        Rms of what the model leaves over the rms measured, in the band [-].
    notes : tuple of str
        What the user should know, a sentence each.
    recordings : tuple of (str, str, str)
        Id of the test, name and SHA-256 of each recording that went in.
    wireframe : Wireframe, optional
        Lines and surfaces on which the shapes are drawn.
    """

    __test__ = False

    name: str
    test: Test
    sensors: tuple[Channel, ...]
    positions: tuple[Place | None, ...]
    directions: tuple[Place | None, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    input_places: tuple[tuple[Place | None, Place | None], ...]
    band: tuple[float, float]
    modes: ModeSet
    functions: Functions | None
    density: FloatArray
    unexplained: FloatArray
    notes: tuple[str, ...]
    recordings: tuple[tuple[str, str, str], ...]
    wireframe: Wireframe | None = None

    @property
    def sensor_names(self) -> list[str]:
        """Names of the sensors, in the order of the shapes."""
        return [channel.name for channel in self.sensors]

    @property
    def geometry(self) -> Geometry:
        """The sensors and the structure that they sit on, projected for a drawing."""
        return geometry_of(self.positions, self.directions, self.wireframe)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Reciprocal:
    """Two response functions between the same two places, one there and one back.

    Attributes
    ----------
    names : (str, str)
        Test, response and input of each.
    units : (str, str)
        Of response and input.
    frequency : (n_frequencies,) array
        Lines that both have [Hz].
    functions : (2, n_frequencies) complex array
        Both, turned the same way round.
    correlation : float
        Real part of their correlation over the lines, -1 to 1 [-].
    ratio : float
        Rms of the second over that of the first [-].
    """

    names: tuple[str, str]
    units: tuple[str, str]
    frequency: FloatArray
    functions: ComplexArray
    correlation: float
    ratio: float

    @property
    def problem(self) -> str:
        """The disagreement; empty where both agree."""
        first, second = self.names
        if self.correlation <= -ALIKE:
            return (
                f"{first} and {second} are reciprocal with the opposite sign: one of their "
                "sensors or forces is the wrong way round"
            )
        if self.correlation < ALIKE:
            return (
                f"{first} and {second} should be reciprocal, but correlate by "
                f"{self.correlation:.2f} only. Places or directions in the log are wrong, the "
                "structure is not linear, or a sensor that was moved shifts its resonances"
            )
        if abs(self.ratio - 1.0) > LEVEL:
            return (
                f"{second} is {numeral(self.ratio)} times its reciprocal {first}: check the "
                "sensitivities of forces and sensors"
            )
        return ""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModalAnalysis:
    """Modes of the tests of a log, or of two.

    Attributes
    ----------
    title : str
        Of the log.
    tests : tuple of TestModes
        Those that could be analysed.
    tracks : tuple of Track
        Each mode through the tests.
    failed : tuple of (str, str)
        Names of those that could not, and why.
    notes : tuple of str
        What concerns several tests.
    reciprocals : tuple of Reciprocal
        Response functions between the same two places, there and back.
    """

    title: str
    tests: tuple[TestModes, ...]
    tracks: tuple[Track, ...]
    failed: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    reciprocals: tuple[Reciprocal, ...] = ()


def file_name(test: str) -> str:
    """Return how files of a test begin, by its name: letters and digits alone."""
    return "test_" + "".join(c if c.isascii() and c.isalnum() else "_" for c in test)


COHERENT: Final = 0.9
"""Coherence below which a line takes no part [-]: noise and leakage are not reciprocal."""

FEWEST: Final = 8
"""Lines that two functions are compared with each other by, at least [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Function:
    """A response function and the places of its two ends."""

    name: str
    units: tuple[str, str]
    frequency: FloatArray
    values: ComplexArray
    coherence: FloatArray
    response: ChannelPlace
    force: ChannelPlace


def reciprocals_of(tests: Sequence[TestModes]) -> tuple[Reciprocal, ...]:
    """Return every pair of functions between two places, there and back.

    Within one test of several forces, and between tests, as of a hammer that roves.
    """
    functions = [one for test in tests for one in _functions(test)]
    pairs = (
        _pair(first, second, sense)
        for i, first in enumerate(functions)
        for second in functions[i + 1 :]
        if (sense := _exchanged(first, second))
    )
    return tuple(pair for pair in pairs if pair.frequency.size >= FEWEST)


def _functions(test: TestModes) -> Iterator[_Function]:
    """Yield the functions of a test between two places that are known and differ."""
    if test.functions is None:
        return
    for k, force in enumerate(test.input_places):
        for i, response in enumerate(zip(test.positions, test.directions, strict=True)):
            if None in (force[0], response[0]) or sense_of(force, response):
                continue
            name = f"test {test.name}, {test.sensors[i].name} / {test.inputs[k]}"
            yield _Function(
                name, (test.sensors[i].unit, test.input_units[k]), test.functions.frequency,
                test.functions.measured[i, k], test.functions.coherence[i], response, force,
            )  # fmt: skip


def _exchanged(first: _Function, second: _Function) -> float:
    """Return 1 or -1 where two functions have exchanged ends, 0 where they have not."""
    if first.units != second.units:
        return 0.0
    return sense_of(first.response, second.force) * sense_of(second.response, first.force)


def _pair(first: _Function, second: _Function, sense: float) -> Reciprocal:
    inside = (first.frequency >= second.frequency[0]) & (
        first.frequency <= second.frequency[-1]
    )
    there = np.interp(first.frequency, second.frequency, second.coherence)
    inside &= (first.coherence > COHERENT) & (there > COHERENT)
    frequency, one = first.frequency[inside], first.values[inside]
    other = sense * np.interp(frequency, second.frequency, second.values)
    size, other_size = (float(np.sqrt(np.sum(np.abs(row) ** 2))) for row in (one, other))
    both = size * other_size
    return Reciprocal(
        (first.name, second.name),
        first.units,
        frequency,
        np.stack([one, other]),
        float(np.vdot(one, other).real) / both if both > 0.0 else 0.0,
        other_size / size if size > 0.0 else 0.0,
    )
