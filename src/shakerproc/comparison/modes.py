"""Modes of a test and of a model, side by side: frequency, damping, MAC, expanded shapes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.measured import Measured
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import ShakerprocError
from shakerproc.modal import ModeSet, mac
from shakerproc.modal.analysis import LEAST_MAC, MOST_SHIFT, TELLING, TestModes
from shakerproc.modal.from_measurements import analyse_test
from shakerproc.modal.geometry import Geometry, geometry_of
from shakerproc.modal.shapes import Expansion, expanded, normalised, scaled_to
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.testlog import TestLog

FARTHEST: Final = 2.0
"""Ratio of frequencies beyond which shapes alike at the sensors are those of other modes: the
next family of a beam or plate lies a factor of 2 or more away [-]."""

MOST_POINTS: Final = 2000
"""Points that shapes are drawn at; of more, those of sensors, joints and forces alone."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class NaturalModes:
    """Modes of the linear part of a model; laws that are not linear are left out.

    Attributes
    ----------
    frequency, damping : (n_modes,) array
        Undamped natural frequency [Hz], rising, and damping ratio [-].
    shapes : (n_modes, n_places) complex array
        Displacement of places against the base, in any scale [-].
    """

    frequency: FloatArray
    damping: FloatArray
    shapes: ComplexArray


@final
@dataclass(frozen=True, slots=True)
class ModePair:
    """A mode of a test beside that of the model; None for a partner that is missing.

    Attributes
    ----------
    measured_hz, model_hz : float or None
        Natural frequencies [Hz].
    measured_damping, model_damping : float or None
        Damping ratios [-].
    mac : float or None
        Modal assurance criterion of both shapes at the sensors [-]; None of a single sensor.
    rows : (int or None, int or None)
        Number of the mode in the test and near the band of the model, from 0.
    missed, left_out : float or None
        What the expansion of the measured shape leaves of the sensors, and of each as predicted
        from the others; rms over what they measured [-].
    """

    measured_hz: float | None
    model_hz: float | None
    measured_damping: float | None
    model_damping: float | None
    mac: float | None = None
    rows: tuple[int | None, int | None] = (None, None)
    missed: float | None = None
    left_out: float | None = None

    @property
    def difference(self) -> float | None:
        """Frequency of the model less that of the test, over the latter [-]."""
        if self.measured_hz is None or self.model_hz is None:
            return None
        return self.model_hz / self.measured_hz - 1.0


@final
@dataclass(frozen=True, slots=True, eq=False)
class Shapes:
    """Shapes of a test, expanded, and of a model, at points of the model.

    Attributes
    ----------
    points : tuple of str
        Their names.
    of : int
        How many points the model has.
    geometry : Geometry
        Where they are, for a drawing.
    expansion : Expansion
        Those of the test.
    model : (n_model, n_points) complex array
        Those of the model near the band, in any scale [-].
    """

    points: tuple[str, ...]
    of: int
    geometry: Geometry
    expansion: Expansion
    model: ComplexArray

    def of_pair(self, pair: ModePair) -> tuple[ComplexArray | None, ComplexArray | None]:
        """Return both shapes of a pair, (n_points,), the second scaled to the first.

        Turned to their mean phase, the largest component of that of the test 1 [-].
        """
        test, model = (
            None if row is None else normalised(shapes[[row]])
            for row, shapes in zip(pair.rows, (self.expansion.shapes, self.model), strict=True)
        )
        if test is not None and model is not None:
            model = scaled_to(model, test)
        return None if test is None else test[0], None if model is None else model[0]

    @property
    def sentence(self) -> str:
        """How well the expansion reproduces the sensors, in the worst mode."""
        found = self.expansion
        if not found.missed.size:
            return ""
        some = "" if self.of == len(self.points) else f" of {self.of} (sensors and joints)"
        told = (
            f"Measured shapes are expanded to {len(self.points)} points{some} by modes of the "
            f"model (SEREP). They miss the sensors by {found.missed.max():.2g} of their rms at "
            f"most; sensors that are left out are missed by {found.left_out.max():.2g}."
        )
        guessed = int(np.count_nonzero(found.left_out**2 > 0.5))
        if guessed:
            told += (
                f" In {guessed} of {found.left_out.size} modes sensors do not tell half of the "
                f"power of one that is left out: shapes between the sensors are a guess there."
            )
        return told


@final
@dataclass(frozen=True, slots=True, eq=False)
class ComparedModes:
    """Modes of a test and of a model.

    Attributes
    ----------
    test : str
        Which test.
    sensors : tuple of str
        Over which shapes are compared.
    pairs : tuple of ModePair
        By frequency, those without partner among them.
    macs : (n_measured, n_model) array
        MAC of every mode of the test with every mode of the model in the band [-].
    shapes : Shapes, optional
        Those of both at the points of the model; None where nothing can be expanded.
    """

    test: str
    sensors: tuple[str, ...]
    pairs: tuple[ModePair, ...]
    macs: FloatArray
    shapes: "Shapes | None" = None

    @property
    def sentence(self) -> str:
        """How far the frequencies are apart, and what has no partner."""
        shifts = [(pair.difference or 0.0, pair) for pair in self.pairs if pair.difference]
        told = f"Test {self.test} and the model have no mode in common."
        if shifts:
            worst, pair = max(shifts, key=lambda one: abs(one[0]))
            told = (
                f"Of {len(shifts)} modes in common with test {self.test} the model is off most "
                f"at {pair.measured_hz:.4g} Hz: {100.0 * worst:+.2g} %."
            )
        alone = [f"{p.measured_hz:.4g} Hz" for p in self.pairs if p.model_hz is None]
        if alone:
            told += f" The model has no partner for {', '.join(alone)}."
        return told


def natural_modes(model: Model, places: Sequence[str]) -> NaturalModes:
    """Return the modes of the linear part of a model, with shapes at places."""
    linear = coordinates_of(model)
    n = linear.mass.size
    by_mass = 1.0 / linear.mass[:, np.newaxis]
    state = np.block([
        [np.zeros((n, n)), np.eye(n)],
        [-by_mass * linear.stiffness, -by_mass * linear.damping],
    ])
    poles, vectors = np.linalg.eig(state)
    turning = np.flatnonzero(poles.imag > 0.0)
    turning = turning[np.argsort(np.abs(poles[turning]))]
    rows = np.array([linear.at(place) for place in places]).reshape(-1, n)
    poles = poles[turning]
    return NaturalModes(
        np.abs(poles) / (2.0 * np.pi),
        -poles.real / np.abs(poles),
        np.asarray((rows @ vectors[:n, turning]).T, np.complex128),
    )


def compared_modes(model: Model, log: TestLog, tests: Sequence[Measured]) -> ComparedModes:
    """Return the modes of the test of the smallest drive that tells any beside a model's.

    Parameters
    ----------
    model : Model
        What is compared; its structure, masses and joints.
    log : TestLog
        How modes are looked for (``modal:``).
    tests : sequence of Measured
        The tests that are compared.

    Raises
    ------
    ShakerprocError
        If no test has a band in which modes can be looked for, or its recording does not
        allow it.
    """
    banded = [test for test in tests if test.test.band is not None]
    if not banded:
        raise ShakerprocError("no test has a band (from, to) in which to look for modes")
    chosen, found = _gentlest(log, sorted(banded, key=lambda one: float(np.std(one.input))))
    moving = {
        name: sensor.at
        for name, sensor in model.sensors.items()
        if sensor.measures == "acceleration" and sensor.at != BASE
    }
    return beside_model(model.under(chosen.conditions), found, moving, chosen.name)


def beside_model(
    model: Model, found: TestModes, places: Mapping[str, str], test: str
) -> ComparedModes:
    """Return the modes of one test beside those of a model.

    Parameters
    ----------
    model : Model
        The model.
    found : TestModes
        The modes of the test.
    places : mapping of str to str
        Place of each sensor on the structure, by its name.
    test : str
        Name of the test.
    """
    names = [name for name in found.sensor_names if name in places]
    rows = [found.sensor_names.index(name) for name in names]
    seats = {places[name]: row for name, row in zip(names, rows, strict=True)}
    points, of = _points(model, seats)
    every = natural_modes(model, [*(places[name] for name in names), *points])
    low, high = found.band
    inside = (every.frequency > low / FARTHEST) & (every.frequency < FARTHEST * high)
    at_sensors, at_points = np.split(every.shapes[inside], [len(names)], axis=1)
    kept = NaturalModes(every.frequency[inside], every.damping[inside], at_sensors)
    measured = found.modes.shapes[:, rows]
    macs = mac(measured, at_sensors)
    pairs = paired(found.modes, kept, macs, len(names), (low, high))
    far = np.abs(np.log(found.modes.frequency[:, np.newaxis] / kept.frequency))
    for pair in pairs:
        if None not in pair.rows:
            far[pair.rows] = -1.0  # the partner first
    expansion = expanded(measured, at_sensors, at_points, far)
    if expansion is None:
        return ComparedModes(test, tuple(names), pairs, macs)
    geometry = _geometry(model, found, points, seats)
    shapes = Shapes(points, of, geometry, expansion, at_points)
    pairs = tuple(_with_expansion(pair, expansion) for pair in pairs)
    return ComparedModes(test, tuple(names), pairs, macs, shapes)


def _with_expansion(pair: ModePair, expansion: Expansion) -> ModePair:
    row = pair.rows[0]
    if row is None:
        return pair
    missed, left_out = float(expansion.missed[row]), float(expansion.left_out[row])
    return replace(pair, missed=missed, left_out=left_out)


def _points(model: Model, seats: Mapping[str, int]) -> tuple[tuple[str, ...], int]:
    """Return places of a model to draw shapes at, and how many do not move about an axis."""
    every = [*model.masses, *(p for one in model.structures.values() for p in one.points)]
    moving = [place for place in every if "/about " not in place]
    if len(moving) <= MOST_POINTS:
        return tuple(moving), len(moving)
    told = {*seats, *(place for one in model.elements for place in one.between)}
    told.add(str(model.excitation.on))
    return tuple(place for place in moving if place in told), len(moving)


def _geometry(
    model: Model, found: TestModes, points: Sequence[str], seats: Mapping[str, int]
) -> Geometry:
    """Return points of a model for a drawing, where its structures or else sensors are."""
    positions, directions = [], []
    owner = {point: one for one in model.structures.values() for point in one.points}
    for point in points:
        body, row = owner.get(point), seats.get(point)
        where = None if body is None else body.position_of(point)
        along = None if body is None else body.direction_of(point)
        if row is not None:
            where, along = where or found.positions[row], along or found.directions[row]
        positions.append(where)
        directions.append(along)
    return geometry_of(positions, directions, found.wireframe)


def _gentlest(log: TestLog, tests: Sequence[Measured]) -> tuple[Measured, TestModes]:
    """Return the first of some tests that can be analysed, and its modes.

    Raises
    ------
    ShakerprocError
        If none can; why the first cannot.
    """
    failed: list[ShakerprocError] = []
    for one in tests:
        try:
            return one, analyse_test(log, one.test, log.modal)
        except ShakerprocError as error:
            failed.append(error)
    raise failed[0]


def paired(
    measured: ModeSet,
    model: NaturalModes,
    macs: FloatArray,
    n_sensors: int,
    band: tuple[float, float],
) -> tuple[ModePair, ...]:
    r"""Return modes with their partners, by least sum of :math:`1 - MAC + |\ln f_1 / f_2|`.

    Parameters
    ----------
    measured, model : ModeSet, NaturalModes
        Both sets.
    macs : (n_measured, n_model) array
        MAC of every pair [-].
    n_sensors : int
        Over which shapes are compared; fewer than three do not tell modes apart, and
        frequencies alone count.
    band : (float, float)
        Within which a mode of the model without partner is told [Hz].
    """
    shift = np.abs(np.log(measured.frequency[:, np.newaxis] / model.frequency))
    told = n_sensors >= TELLING
    cost = shift + float(told) * (1.0 - macs)
    never = shift > (np.log(FARTHEST) if told else MOST_SHIFT)
    if told:
        never |= macs < LEAST_MAC
    rows, columns = scipy.optimize.linear_sum_assignment(np.where(never, 1e6, cost))
    partners = {int(i): int(j) for i, j in zip(rows, columns, strict=True) if not never[i, j]}
    pairs = []
    for i, frequency in enumerate(measured.frequency):
        j = partners.get(i)
        pairs.append(
            ModePair(
                float(frequency),
                None if j is None else float(model.frequency[j]),
                float(measured.damping[i]),
                None if j is None else float(model.damping[j]),
                None if j is None or n_sensors < 2 else float(macs[i, j]),
                (i, j),
            )
        )
    for j, frequency in enumerate(model.frequency):
        if j not in partners.values() and band[0] <= frequency <= band[1]:
            alone = (None, float(frequency), None, float(model.damping[j]))
            pairs.append(ModePair(*alone, rows=(None, j)))
    return tuple(sorted(pairs, key=lambda one: one.measured_hz or one.model_hz or 0.0))
