"""The tests of a campaign as the residual needs them, and parts of them."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.comparison.held_out import held_out_samples
from shakerproc.comparison.own import as_means, constant_spread
from shakerproc.comparison.prediction import DRAWS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest, RelativeMotion
from shakerproc.diagnosis.data.controls import NO_SWAYS, Sways, sways_of
from shakerproc.diagnosis.data.motion import coordinate_motions, frequency_of, joint_motion
from shakerproc.diagnosis.estimation.offsets import Offsets, offsets_of
from shakerproc.diagnosis.estimation.parts import Lengths, Windows
from shakerproc.diagnosis.estimation.stacks import TAPS, Stack, stacks_of
from shakerproc.diagnosis.hypotheses.joints import joints_of
from shakerproc.models import Model
from shakerproc.simulation import Input
from shakerproc.simulation.inputs import prepare_like, prepare_measured

MODEL_SHARE: Final = 1e-3
"""Share of a response to which no model is held: calibration, noise of the controls [-]."""

ENVELOPE_S: Final = 0.05
"""Length over which the size of a response is taken: some periods of most resonances [s]."""


def uncertainty(test: PreparedTest) -> FloatArray:
    """Return the standard deviation of each sample, (n_sensors, n) array.

    Noise of the sensor, and a share of the response as it is just then.
    """
    size = max(8, round(ENVELOPE_S * test.sample_rate))
    squared = scipy.ndimage.uniform_filter1d(test.responses**2, size, axis=1)
    local = MODEL_SHARE * np.sqrt(np.maximum(squared, 0.0))
    found: FloatArray = np.hypot(np.maximum(test.noise, 1e-300)[:, None], local)
    return found


@final
@dataclass(frozen=True, eq=False)
class DataSet:
    """Tests ready for the residual.

    Attributes
    ----------
    model : Model
        Says what each sensor measures; its linear part completes the measured motion.
    tests : tuple of PreparedTest
        In the order of the log.
    points : bool
        Whether accelerations are compared as values at the samples; else as means over the
        sample that follows.
    differing : bool
        Whether springs have a stiffness of their own in each test, and what drives them may be
        between controls that disagree (see `of_tests`).
    near : tuple of Input
        What drives the tests without the noise that was drawn beside them; inputs are prepared
        in as many parts.
    """

    model: Model
    tests: tuple[PreparedTest, ...]
    points: bool = False
    differing: bool = False
    near: tuple[Input, ...] = ()

    def as_values(self) -> "DataSet":
        """Return the tests with accelerations as values at the samples (see `points`)."""
        return self._sharing(replace(self, points=True), _WHATEVER_COMPARED)

    def as_differing(self) -> "DataSet":
        """Return the tests with what each has of its own (see `differing`)."""
        return self if self.differing else self._differing

    @cached_property
    def _differing(self) -> "DataSet":
        return self._sharing(replace(self, differing=True), _WHATEVER_DIFFERS)

    @property
    def plain(self) -> "DataSet":
        """The tests as `compare` takes them: all alike, driven by the mean of the controls."""
        return self._plain if self.differing else self

    @cached_property
    def _plain(self) -> "DataSet":
        return self._sharing(replace(self, differing=False), _WHATEVER_DIFFERS)

    def _sharing(self, other: "DataSet", names: frozenset[str]) -> "DataSet":
        """Return another data set of the same tests, with what was computed of this one."""
        other.__dict__.update({k: v for k, v in self.__dict__.items() if k in names})
        if "shaken" in self.__dict__:
            other.__dict__["shaken"] = tuple(
                one._sharing(replace(other, tests=one.tests, near=one.near), names)
                for one in self.shaken
            )
        return other

    @property
    def n_sensors(self) -> int:
        """Responses of each test."""
        return len(self.model.sensors)

    @cached_property
    def inputs(self) -> tuple[Input, ...]:
        """Excitation of each test, prepared for the engine."""
        if self.near:
            return tuple(
                prepare_like(test.input, given)
                for test, given in zip(self.tests, self.near, strict=True)
            )
        imposed = self.model.excitation.imposed
        return tuple(
            prepare_measured(test.input, test.sample_rate, imposed=imposed)
            for test in self.tests
        )

    @cached_property
    def shaken(self) -> "tuple[DataSet, ...]":
        """The tests with as much noise again on inputs and responses, drawn once for all."""
        generators = np.random.default_rng(0).spawn(DRAWS)
        tests = [tuple(test.shaken(own) for test in self.tests) for own in generators]
        draws = [replace(self, tests=own, near=self.inputs) for own in tests]
        return tuple(self._sharing(one, _WHATEVER_DRAWN) for one in draws)

    @cached_property
    def gain_spreads(self) -> tuple[float, FloatArray]:
        """Standard uncertainty of the gain of the input and of those of the responses [-].

        The largest of any test; one gain is fitted to all.
        """
        each = [test.arrays.gain_spreads for test in self.tests]
        largest: FloatArray = np.max([responses for _, responses in each], axis=0)
        return max(own for own, _ in each), largest

    @property
    def has_constants(self) -> bool:
        """Whether what drives each test has an unknown constant: where it is a force."""
        return self.model.excitation.kind == "force"

    @cached_property
    def offsets(self) -> Offsets:
        """Offsets of sensors that the tests are too short to tell."""
        return offsets_of(self.model, self.tests)

    @cached_property
    def driven(self) -> dict[bytes, tuple[Input, ...]]:
        """Inputs with what tests have of their own, as last asked for (see `of_tests`)."""
        return {}

    @cached_property
    def sways(self) -> Sways:
        """How the controls disagree."""
        moves = self.differing and not self.model.excitation.imposed
        return sways_of(self.tests) if moves else NO_SWAYS

    @cached_property
    def sway_pieces(self) -> tuple[FloatArray, ...]:
        """Sway as pieces of inputs, (n, n_pieces, degree + 1) arrays."""
        return tuple(
            np.array([prepare_like(row, given).pieces for row in rows])
            for rows, given in zip(self.sways.signals, self.inputs, strict=True)
        )

    @cached_property
    def input_sizes(self) -> FloatArray:
        """Rms of the input of each test, which its constant is compared with, (n_tests,)."""
        sizes = [float(np.sqrt(np.mean(test.input**2))) for test in self.tests]
        return np.maximum(sizes, 1e-300)

    @cached_property
    def constant_spreads(self) -> FloatArray:
        """Standard deviation of the constant of each input over its rms, (n_tests,) [-]."""
        spreads = [constant_spread(test.input, test.quiet) for test in self.tests]
        return np.array(spreads) / self.input_sizes

    @cached_property
    def measured(self) -> tuple[FloatArray, ...]:
        """Responses, accelerations as means or values (see `points`), (n_sensors, n)."""
        if self.points:
            return tuple(test.responses for test in self.tests)
        return tuple(as_means(self.model, test.responses) for test in self.tests)

    @cached_property
    def kept(self) -> tuple[NDArray[np.bool_], ...]:
        """Which samples of each test are held out, (n,) arrays.

        See `compare.held_out_samples`.
        """
        return held_out_samples(
            [test.input for test in self.tests],
            [test.responses for test in self.tests],
            [(test.start, test.stop) for test in self.tests],
            [test.arrays.hold_out for test in self.tests],
        )

    def stretches(self, *, held_out: bool) -> tuple[tuple[tuple[int, int], ...], ...]:
        """Return first sample and end of what is held out of each test, or is not."""
        return tuple(
            _runs(test, kept == held_out)
            for test, kept in zip(self.tests, self.kept, strict=True)
        )

    @cached_property
    def motions(self) -> tuple[FloatArray, ...]:
        """Displacements [m], then velocities [m/s], (2 n_coordinates, n) arrays."""
        return tuple(coordinate_motions(self.model, test) for test in self.tests)

    @cached_property
    def motion_sizes(self) -> FloatArray:
        """Largest of these in any test, (2 n_coordinates,) array [m], [m/s]."""
        each = [np.max(np.abs(motion), axis=1) for motion in self.motions]
        return np.asarray(np.max(each, axis=0))

    @cached_property
    def frequency(self) -> float:
        """Frequency of the motion of the joint that moves fastest [Hz]."""
        return max(frequency_of(self.across(joint)) for joint in joints_of(self.model))

    @cached_property
    def lengths(self) -> Lengths:
        """How long windows and blocks are."""
        rate = self.tests[0].sample_rate
        fitted, held_out = (
            tuple((b - a) / rate for runs in self.stretches(held_out=kept) for a, b in runs)
            for kept in (False, True)
        )
        return Lengths(self.frequency, fitted, held_out, (TAPS + 2) / rate)

    def across(self, joint: tuple[str, str]) -> tuple[RelativeMotion, ...]:
        """Return, for each test, the motion of the second place less that of the first."""
        if joint not in self._across:
            self._across[joint] = tuple(
                joint_motion(self.model, motion, joint) for motion in self.motions
            )
        return self._across[joint]

    @cached_property
    def _across(self) -> dict[tuple[str, str], tuple[RelativeMotion, ...]]:
        return {}

    def largest_across(self, joint: tuple[str, str]) -> float:
        """Return the largest displacement of the second place less that of the first [m]."""
        if joint not in self._largest:
            each = [np.max(np.abs(one.displacement)) for one in self.across(joint)]
            self._largest[joint] = float(max(each))
        return self._largest[joint]

    @cached_property
    def _largest(self) -> dict[tuple[str, str], float]:
        return {}

    @cached_property
    def noise(self) -> tuple[FloatArray, ...]:
        """Standard deviation of each sample, (n_sensors, n) arrays [unit of the sensor].

        Beside the noise of the sensor a share of the response as it is just then: calibration,
        and what the noise of the controls becomes in a resonance.
        """
        return tuple(uncertainty(test) for test in self.tests)

    @cached_property
    def _stacks(self) -> dict[Windows, tuple[Stack, ...]]:
        return {}

    def stacks(self, windows: Windows) -> tuple[Stack, ...]:
        """Return windows side by side; those of each set are made once."""
        if windows not in self._stacks:
            self._stacks[windows] = stacks_of(self, windows)
        return self._stacks[windows]


_WHATEVER_DRAWN: Final = frozenset({"sways", "sway_pieces", "offsets"})
"""What was computed of a data set and does not depend on noise that is drawn beside it."""

_WHATEVER_COMPARED: Final = frozenset({
    "inputs", "input_sizes", "constant_spreads", "kept", "motions", "motion_sizes",
    "frequency", "lengths", "_across", "_largest", "noise", *_WHATEVER_DRAWN,
})  # fmt: skip
"""What was computed of a data set and does not depend on how accelerations are compared."""

_WHATEVER_DIFFERS: Final = _WHATEVER_COMPARED - _WHATEVER_DRAWN | {"measured", "_stacks"}
"""The same of what tests have of their own."""


def _runs(test: PreparedTest, mask: NDArray[np.bool_]) -> tuple[tuple[int, int], ...]:
    """Return first sample and end of each stretch of the judged part of a test."""
    judged = mask.copy()
    judged[: test.start] = False
    judged[test.stop :] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], judged, [False]]).astype(int)))
    return tuple((int(a), int(b)) for a, b in edges.reshape(-1, 2))
