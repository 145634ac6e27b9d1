"""Simulated tests of one level: numbers, calibration and phases drawn anew for each."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final, final

import numpy as np

from shakerproc.comparison import Measured
from shakerproc.data import FloatArray
from shakerproc.diagnosis.fitted_numbers import FittedNumbers
from shakerproc.errors import SimulationError
from shakerproc.forecasts.extremes import largest_in
from shakerproc.forecasts.motion import Motion, motion_of
from shakerproc.forecasts.quantities import Quantity, densities, values_of_motion
from shakerproc.models import Model
from shakerproc.planning.drive import drive_of_test
from shakerproc.simulation.inputs import prepare_like, prepare_measured
from shakerproc.testlog import Test

MOST_DRAWS: Final = 60
"""Simulated tests of a level: three lie beyond each end of a 90 % band [-]."""

LEAST_DRAWS: Final = 16
"""Simulated tests of a level, however long they are [-]."""

MOST_SAMPLES: Final = 2**23
"""Samples of all simulated tests of a level, beyond which there are fewer of them: some ten
seconds of a processor [-]."""

LONGEST: Final = 60.0
"""Duration of steady vibration that is simulated; what is longer follows from it [s]."""

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
    carried : float, optional
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
    carried: float | None = None
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
    values : mapping of Quantity to (n_draws,) array
        What each gave [unit of the quantity].
    frequency : (n_frequencies,) array
        Of the densities [Hz].
    densities : mapping of str to (n_draws, n_frequencies) array
        Of each response [unit^2/Hz].
    failed : int
        Draws whose motion ran away; they are left out.
    motion : Motion
        Of the fitted numbers, without any error of calibration.
    """

    values: Mapping[Quantity, FloatArray]
    frequency: FloatArray
    densities: Mapping[str, FloatArray]
    failed: int
    motion: Motion


def spreads_of(tests: tuple[Measured, ...]) -> tuple[float, FloatArray]:
    """Return the standard uncertainty of the gain of the input and of each response [-]."""
    found = []
    for test in tests:
        n = len(test.controls)
        each = np.array(test.gain_spread)
        found.append((float(np.sqrt(np.sum(each[:n] ** 2))) / n, each[n:]))
    return max(one for one, _ in found), np.max([each for _, each in found], axis=0)


def ensemble(
    numbers: FittedNumbers,
    planned: Planned,
    factor: float = 1.0,
    seed: int = 0,
    most: int = MOST_DRAWS,
) -> Ensemble:
    """Return simulated tests of one level.

    Parameters
    ----------
    numbers : FittedNumbers
        What the tests tell of the model.
    planned : Planned
        The test.
    factor : float
        Amplitude over that of the log [-].
    seed : int
        Of what is drawn: the same at every level.
    most : int
        Simulated tests at most.

    Raises
    ------
    SimulationError
        If most of the motions run away.
    """
    size = planned.simulated * planned.sample_rate
    count = int(np.clip(MOST_SAMPLES // size, LEAST_DRAWS, most))
    drawn = numbers.drawn(count, np.random.default_rng([seed, 0]))
    drives = _Drives(planned, factor, seed)
    best = drives.motion(0, numbers.model, numbers.gain, 1.0)
    values, drawn_densities, frequency = [], [], np.zeros(0)
    longer = planned.duration / planned.simulated
    for i, (model, gains) in enumerate(drawn):
        generator = np.random.default_rng([seed, 2, i])
        of_input, of_sensors = planned.spreads
        louder = 1.0 + of_input * generator.standard_normal()
        off = 1.0 + of_sensors * generator.standard_normal(gains.size)
        motion = drives.motion(i, model, gains * off, louder)
        if motion is None:
            continue
        rows = np.array(list(motion.responses.values()))
        spectra = densities(rows, motion.sample_rate, planned.excited)
        largest = partial(_largest, longer, generator)
        values.append(values_of_motion(model, motion, spectra, largest, planned.carried))
        frequency = spectra[0].frequency
        drawn_densities.append([one.values for one in spectra])
    if best is None or 2 * len(values) < count:
        raise SimulationError(
            f"{planned.test.source}: test {planned.test.id}: the motion of "
            f"{numbers.model.title} runs away in {count - len(values)} of {count} draws of its "
            "numbers; these tests do not tell them well enough for this level."
        )
    names = list(numbers.model.sensors)
    stacked = np.array(drawn_densities)
    return Ensemble(
        {q: np.array([one[q] for one in values]) for q in values[0]},
        frequency,
        {name: stacked[:, i] for i, name in enumerate(names)},
        count - len(values),
        best,
    )


def _largest(longer: float, generator: np.random.Generator, samples: FloatArray) -> float:
    """Return the largest size in a duration, over that of the samples [-], by chance."""
    return largest_in(samples, longer, generator.random())


@final
class _Drives:
    """What drives the simulated tests of a level: phases drawn anew for each."""

    def __init__(self, planned: Planned, factor: float, seed: int) -> None:
        self.planned, self.factor, self.seed = planned, factor, seed
        first = self._samples(0)
        self.first = prepare_measured(first, planned.sample_rate, imposed=False)

    def motion(
        self, number: int, model: Model, gains: FloatArray, louder: float
    ) -> Motion | None:
        """Return the motion of a model in one of the tests; None where it runs away.

        `gains` are those of the sensors, `louder` that of the drive [-].
        """
        drive = louder * self._samples(number)
        given = prepare_like(drive, self.first)
        planned = self.planned
        return motion_of(model, given, drive, planned.compared, gains, table=planned.table)

    def _samples(self, number: int) -> FloatArray:
        planned, generator = self.planned, np.random.default_rng([self.seed, 1, number])
        samples = drive_of_test(planned.test, planned.simulated, planned.sample_rate, generator)
        return self.factor * samples
