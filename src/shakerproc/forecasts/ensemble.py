"""Simulated tests of one level: numbers, calibration and phases drawn anew for each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.comparison import Measured
from shakerproc.data import FloatArray
from shakerproc.diagnosis.fitted_numbers import FittedNumbers
from shakerproc.errors import SimulationError
from shakerproc.forecasts.motion import TestMotion, motion_of
from shakerproc.forecasts.notches import passage
from shakerproc.forecasts.quantities import (
    Quantity,
    densities,
    largest_in,
    samples_of,
    values_of_motion,
)
from shakerproc.models import Model
from shakerproc.planning.drive import drive_of_test
from shakerproc.runs.opening import stated
from shakerproc.simulation.inputs import prepare_like, prepare_measured
from shakerproc.testlog import Test

MOST_DRAWS: Final = 60
"""Simulated tests of a level: three lie beyond each end of a 90 % band [-]."""

LEAST_DRAWS: Final = 16
"""Simulated tests of a level, however long they are [-]."""

MOST_SAMPLES: Final = 2**22
"""Samples of all simulated tests of a level, beyond which there are fewer of them: some three
seconds of a processor [-]."""

PAIRED_DRAWS: Final = 6
"""Simulated tests of another level, each beside one of the same numbers and phases [-]."""

LONGEST: Final = 60.0
"""Duration of steady vibration that is simulated; what is longer follows from it [s]."""

CLOCKS: Final = 4e-5
"""Standard uncertainty of a frequency by the clocks of controller and recorder, crystals that
keep to 50 in a million each [-]."""

STEADY: Final = ("random", "sine on random")
"""Kinds of excitation that are the same all along."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Planned:
    """A test to forecast.

    Attributes
    ----------
    test : Test
        What the log says.
    duration : float
        How long it shakes [s].
    sample_rate : float
        Of the campaign [Hz].
    excited, compared : (float, float)
        What it excites, and within which responses are recorded [Hz].
    spreads : (float, (n_sensors,) array)
        Standard uncertainty of the gain of the input and of each response [-].
    shaker_mass : float, optional
        Mass that the shaker moves besides the model [kg].
    table : bool
        Whether the motion of the table is judged.
    """

    test: Test
    duration: float
    sample_rate: float
    excited: tuple[float, float]
    compared: tuple[float, float]
    spreads: tuple[float, FloatArray]
    shaker_mass: float | None = None
    table: bool = False

    @property
    def simulated(self) -> float:
        """Duration that is simulated [s]."""
        steady = self.test.excitation in STEADY
        return min(self.duration, LONGEST) if steady else self.duration


@final
@dataclass(frozen=True, slots=True, eq=False)
class Ensemble:
    """Simulated tests of one level.

    Attributes
    ----------
    draws : (n_draws,) array of int
        Number of each; the same number is the same phases, numbers and calibration.
    values : mapping of Quantity to (n_draws,) array
        What each gave, by sensors without error [unit of the quantity].
    frequency : (n_frequencies,) array
        Of the densities [Hz].
    densities : mapping of str to (n_draws, n_frequencies) array
        Of each response, as sensors read it [unit^2/Hz].
    failed : int
        Draws whose motion ran away; they are left out.
    read : mapping of Quantity to float
        Standard uncertainty of what each is read with, which is in no draw of it [-].
    passed : mapping of Quantity to (n_bins,) array
        How the quantities that were watched follow the drive (see `passages`).
    """

    draws: NDArray[np.int64]
    values: Mapping[Quantity, FloatArray]
    frequency: FloatArray
    densities: Mapping[str, FloatArray]
    failed: int
    read: Mapping[Quantity, float] = field(default_factory=dict)
    passed: Mapping[Quantity, FloatArray] = field(default_factory=dict)

    def changed_as(self, there: "Ensemble") -> "Ensemble":
        r"""Return all draws in another test, of which a few were simulated.

        .. math:: x_i' = x_i \exp\left(\frac{1}{m} \sum_{k=1}^{m} \ln \frac{x_k'}{x_k}\right)

        Of the same numbers and phases the ratio scatters far less than the values do.

        Parameters
        ----------
        there : Ensemble
            Of the other test; draws that are here and there count.
        """
        _, mine, other = np.intersect1d(self.draws, there.draws, return_indices=True)
        changed = {}
        for quantity, values in self.values.items():
            before, after = values[mine], there.values[quantity][other]
            changed[quantity] = values * np.exp(np.mean(np.log(after / before)))
        return replace(self, values=changed)


def spreads_of(tests: tuple[Measured, ...]) -> tuple[float, FloatArray]:
    """Return the standard uncertainty of the gain of the input and of each response [-]."""
    sensor_spreads = []
    for test in tests:
        n = len(test.controls)
        each = np.array(test.gain_spread)
        sensor_spreads.append((float(np.sqrt(np.sum(each[:n] ** 2))) / n, each[n:]))
    return max(one for one, _ in sensor_spreads), np.max(
        [each for _, each in sensor_spreads], axis=0
    )


def n_draws(planned: Planned) -> int:
    """Return how many tests of a level are simulated [-]."""
    size = planned.simulated * planned.sample_rate
    return int(np.clip(MOST_SAMPLES // size, LEAST_DRAWS, MOST_DRAWS))


def even_normals(count: int, columns: int, generator: np.random.Generator) -> FloatArray:
    """Return standard normal errors that fill their law evenly, (count, columns) array [-].

    Each column has one value in each of as many equally likely parts, in an order of its own
    [1]_: of 60 errors drawn freely the median is off by 0.16 of a standard deviation.

    Parameters
    ----------
    count : int
        How many.
    columns : int
        Errors that are independent of each other.
    generator : numpy.random.Generator
        Where the randomness comes from.

    References
    ----------
    .. [1] M. D. McKay, R. J. Beckman, W. J. Conover, "A comparison of three methods for
       selecting values of input variables", Technometrics 21, 239-245, 1979.
    """
    scores = scipy.special.ndtri((np.arange(count) + 0.5) / count)
    orders = np.tile(scores / np.std(scores), (columns, 1))
    return generator.permuted(orders, axis=1).T


def read_with(planned: Planned, names: Sequence[str], quantity: Quantity) -> float:
    """Return the standard uncertainty of the sensor by which a quantity is read [-].

    Parameters
    ----------
    planned : Planned
        The test.
    names : sequence of str
        Its sensors, in their order.
    quantity : Quantity
        Of a joint, a force or a table nothing is read.
    """
    if quantity.what == "peak_frequency_hz":
        return CLOCKS
    if quantity.whose != "response":
        return 0.0
    return float(planned.spreads[1][names.index(quantity.name)])


def ensemble(
    numbers: FittedNumbers,
    drives: "Drives",
    count: int,
    factor: float = 1.0,
    watched: Sequence[Quantity] = (),
) -> Ensemble:
    """Return simulated tests of one level.

    Parameters
    ----------
    numbers : FittedNumbers
        What the tests tell of the model.
    drives : Drives
        What drives them.
    count : int
        How many.
    factor : float
        Amplitude over that of the log [-].
    watched : sequence of Quantity
        Those of which it is wanted how they follow the drive at each frequency.

    Raises
    ------
    SimulationError
        If most of the motions run away.
    """
    planned, seed = drives.planned, drives.seed
    drawn = numbers.drawn(count, np.random.default_rng(0))  # as of levels that were run
    values, drawn_densities, frequency = [], [], np.zeros(0)
    longer, moved = planned.duration / planned.simulated, []
    passed: dict[Quantity, list[FloatArray]] = {quantity: [] for quantity in watched}
    for i, (model, gains) in enumerate(drawn):
        generator = np.random.default_rng([seed, 2, i])
        of_input, of_sensors = planned.spreads
        errors = drives.errors[i]
        louder, off = 1.0 + of_input * errors[0], 1.0 + of_sensors * errors[1:]
        motion = drives.motion(i, model, gains, factor * louder)
        if motion is None:
            continue
        moved.append(i)
        rows = np.array(list(motion.responses.values()))
        spectra = densities(rows, motion.sample_rate, planned.excited)
        largest = partial(_largest, longer, generator)
        values.append(values_of_motion(model, motion, spectra, largest, planned.shaker_mass))
        frequency = spectra[0].frequency
        drawn_densities.append([
            one.values * gain**2 for one, gain in zip(spectra, off, strict=True)
        ])
        for quantity, rows_of in passed.items():
            samples = samples_of(quantity, model, motion, planned.shaker_mass)
            rows_of.append(passage(planned.test, motion, samples))
    if 2 * len(values) < count:
        where = f"in {count - len(values)} of {count} draws of its numbers"
        raise SimulationError(_runs_away(numbers, planned, where))
    names = list(numbers.model.sensors)
    stacked = np.array(drawn_densities)
    return Ensemble(
        np.array(moved),
        {q: np.array([one[q] for one in values]) for q in values[0]},
        frequency,
        {name: stacked[:, i] for i, name in enumerate(names)},
        count - len(values),
        {q: read_with(planned, names, q) for q in values[0]},
        {quantity: np.mean(each, axis=0) for quantity, each in passed.items()},
    )


def fitted_motion(numbers: FittedNumbers, drives: "Drives") -> TestMotion:
    """Return the motion of the fitted numbers, without any error of calibration.

    Raises
    ------
    SimulationError
        If it runs away.
    """
    test_motion = drives.motion(0, numbers.model, numbers.gain, 1.0)
    if test_motion is None:
        raise SimulationError(_runs_away(numbers, drives.planned, "with its fitted numbers"))
    return test_motion


def _runs_away(numbers: FittedNumbers, planned: Planned, where: str) -> str:
    return (
        f"{planned.test.source}: test {planned.test.id}: the motion of {numbers.model.title} "
        f"runs away {where}. Either these tests do not tell them well enough for "
        "this level, or its law ends before it: run a level in between."
    )


def _largest(longer: float, generator: np.random.Generator, samples: FloatArray) -> float:
    """Return the largest size in a duration, over that of the samples [-], by chance."""
    return largest_in(samples, longer, generator.random())


@final
class Drives:
    """Drives of the simulated tests of a plan, phases drawn anew for each.

    Parameters
    ----------
    planned : Planned
        The test.
    seed : int
        Of what is drawn: the same at every level.
    """

    def __init__(self, planned: Planned, seed: int) -> None:
        self.planned, self.seed = planned, seed
        self.errors = even_normals(
            n_draws(planned), 1 + planned.spreads[1].size, np.random.default_rng([seed, 2])
        )  # of the input and of each sensor
        self._first = self._samples(0)
        self._prepared = prepare_measured(self._first, planned.sample_rate, imposed=False)

    def motion(
        self, number: int, model: Model, gains: FloatArray, louder: float
    ) -> TestMotion | None:
        """Return the motion of a model in one of the tests; None where it runs away.

        `gains` are those of the sensors, `louder` that of the drive [-].
        """
        drive = louder * (self._samples(number) if number else self._first)
        given = prepare_like(drive, self._prepared)
        planned = self.planned
        return motion_of(
            model, given, drive, planned.compared, gains,
            conditions=stated(planned.test), table=planned.table,
        )  # fmt: skip

    def _samples(self, number: int) -> FloatArray:
        planned, generator = self.planned, np.random.default_rng([self.seed, 1, number])
        return drive_of_test(planned.test, planned.simulated, planned.sample_rate, generator)
