"""A structure and its tests, ready to be asked how well a hypothesis predicts them."""

from dataclasses import dataclass, replace

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnose import kernel, single
from shakerproc.diagnose.candidates import Candidate
from shakerproc.diagnose.prepare import Prepared
from shakerproc.diagnose.structure import (
    Joint,
    Matrices,
    Structure,
    correction,
    hold,
    matrices,
)


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A stretch of one test: arrays for the observer, and how many samples not to judge."""

    test: int
    name: str
    sample_rate: float
    fine: int
    start: int
    skip: int
    input: FloatArray
    measured: FloatArray
    slope: FloatArray
    weight: FloatArray
    gain_key: int
    hold_out: bool


@dataclass(frozen=True, slots=True)
class Term:
    """A candidate in a joint, and the reduced mass of its two sides [kg]."""

    candidate: Candidate
    joint: int
    mass: float = 1.0


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """What is assumed: terms beside the linear model, and sensor faults that are let free."""

    terms: tuple[Term, ...] = ()
    faults: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Parameters:
    """Numbers of a hypothesis.

    Attributes
    ----------
    stiffness, damping : (n_joints,) array
        Of the linear joints [N/m], [N s/m].
    gain : (n_sensors,) array
        Gain of each response sensor [-].
    delay : (n_sensors,) array
        Delay of each response sensor against the input [s].
    values : tuple of tuple of float
        Parameters of each term.
    """

    stiffness: FloatArray
    damping: FloatArray
    gain: FloatArray
    delay: FloatArray
    values: tuple[tuple[float, ...], ...] = ()


def placed(index: int, n: int) -> int:
    """Return a mass index as the observer counts: the base comes last."""
    return n if index < 0 else index


def assemble(structure: Structure, hypothesis: Hypothesis, p: Parameters) -> Structure:
    """Return the linear structure of a hypothesis: attached modes are masses of their own."""
    linear = structure.with_linear(p.stiffness, p.damping)
    for term, values in zip(hypothesis.terms, p.values, strict=True):
        if term.candidate.kind == "attached_mode":
            mass, frequency, ratio = values
            at = structure.joints[term.joint].b
            omega = 2.0 * np.pi * frequency
            joint = Joint(at, linear.masses.size, mass * omega**2, 2.0 * ratio * mass * omega)
            linear = replace(
                linear,
                masses=np.append(linear.masses, mass),
                joints=(*linear.joints, joint),
            )
    return linear


def reduced_mass(structure: Structure, joint: Joint) -> float:
    """Return the reduced mass of the two sides of a joint [kg]."""
    inverse = sum(1.0 / structure.masses[i] for i in (joint.a, joint.b) if i >= 0)
    return float(1.0 / inverse)


def law_table(
    structure: Structure, hypothesis: Hypothesis, p: Parameters, n: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return ops, parameters and sides of the laws of a hypothesis."""
    ops, numbers, a, b = [], [], [], []
    for term, values in zip(hypothesis.terms, p.values, strict=True):
        joint = structure.joints[term.joint]
        beside = p.stiffness[term.joint]
        if term.candidate.kind == "lugre_friction":
            beside = reduced_mass(structure, joint)
        for op, row in term.candidate.rows(values, float(beside)):
            ops.append(op)
            numbers.append([*row, *[0.0] * (8 - len(row))])
            a.append(placed(joint.a, n))
            b.append(placed(joint.b, n))
    return (
        np.array(ops, dtype=np.int64),
        np.array(numbers, dtype=float).reshape(-1, 8),
        np.array(a, dtype=np.int64),
        np.array(b, dtype=np.int64),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Observed:
    """What an observer makes of a segment.

    Attributes
    ----------
    innovations : (n_sensors, n) array
        Over their expected size [-].
    states : (2 n_masses, n) array
        Displacements and velocities, where they were asked for.
    dense : (n_sensors, n * fine) array
        Sensors on the fine grid, where they were asked for.
    expected : (n_sensors, n) array
        Predicted samples, where they were asked for.
    logs : float
        Sum of the logarithms of the innovations' variances.
    """

    innovations: FloatArray
    states: FloatArray
    dense: FloatArray
    expected: FloatArray
    logs: float


@dataclass(frozen=True, slots=True, eq=False)
class Tuning:
    """Noises that the observer of one test reckons with, and its steady linear correction.

    Attributes
    ----------
    noise : (n_sensors,) array
        Standard deviation of a sample of each sensor.
    input_noise, model_noise : float
        Of the input; of accelerations that no model explains [m/s²].
    rms : float
        Of the response, as an acceleration [m/s²].
    gain, sigma : arrays
        Steady correction of the linear reference, and the size of its innovations.
    """

    noise: FloatArray
    input_noise: float
    model_noise: float
    rms: float
    gain: FloatArray
    sigma: FloatArray

    @property
    def unaided(self) -> bool:
        """Whether the motion is foretold from rest on, and never corrected."""
        return self.rms == 0.0


def tuning(
    structure: Structure,
    sample_rate: float,
    noise: FloatArray,
    input_noise: float,
    model_noise: float,
    rms: float,
) -> Tuning:
    """Return how an observer is corrected; the steady part is that of this linear structure."""
    system = matrices(structure)
    gain, sigma = correction(system, sample_rate, input_noise, noise, model_noise)
    return Tuning(noise, input_noise, model_noise, rms, gain, sigma)


def unaided_tuning(structure: Structure, noise: FloatArray) -> Tuning:
    """Return the noises of an observer that foretells the motion without correcting it."""
    states = 2 * structure.masses.size
    return Tuning(noise, 0.0, 0.0, 0.0, np.zeros((states, noise.size)), noise)


def run(
    structure: Structure,
    table: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    segment: Segment,
    tuned: Tuning,
    p: Parameters,
    *,
    beyond: FloatArray | None = None,
    keep: bool = False,
) -> Observed | None:
    """Return what an observer makes of a segment, or None where the run blew up."""
    system: Matrices = matrices(structure)
    m = structure.masses.size
    step = 1.0 / (segment.sample_rate * segment.fine)
    phi, g0, g1 = hold(system.state, system.input[:, None], step)
    measured = segment.measured if beyond is None else segment.measured + beyond
    measured = (measured + p.delay[:, None] * segment.slope) / p.gain[:, None]
    n = measured.shape[1]
    innovations = np.empty((measured.shape[0], n))
    states = np.empty((2 * m, n if keep else 1))
    dense = np.empty((measured.shape[0], n * segment.fine if keep else 1))
    expected = np.empty((measured.shape[0], n if keep else 1))
    direct = system.out_force / np.diag(system.force[m:])
    omega = float(np.sqrt(np.max(np.abs(system.state[m:, :m]))))
    spread = np.repeat([tuned.rms / omega**2, tuned.rms / omega], m)
    simple = m == 1 and measured.shape[0] == 1 and all(table[2] == 1)
    logs = _one(
        system,
        (phi, g0, g1),
        direct,
        structure,
        segment,
        measured,
        tuned,
        p,
        spread,
        table,
        step,
        keep, SOFTEN if beyond is not None else 0.0, innovations, states, dense, expected,
    ) if simple else kernel.observe(
        phi, g0[:, 0].copy(), g1[:, 0].copy(), system.state[m:].copy(), system.input[m:].copy(),
        system.out, system.out_force, system.out_input, direct, 1.0 / structure.masses,
        segment.input, segment.fine, measured, segment.weight, tuned.noise / p.gain,
        tuned.input_noise, tuned.model_noise, spread, *table, step,
        segment.start / segment.sample_rate, segment.skip, keep, innovations, states, dense,
        expected,
    )  # fmt: skip
    if not np.isfinite(logs):
        return None
    logs += 2.0 * (n - segment.skip) * float(np.sum(np.log(p.gain)))
    return Observed(innovations, states, dense, expected, logs)


def _one(  # type: ignore[no-untyped-def]
    system, propagators, direct, structure, segment, measured, tuned, p, spread, table, step,
    keep, soften, innovations, states, dense, expected,
) -> float:  # fmt: skip
    """Call the kernel for one mass and one sensor."""
    phi, g0, g1 = propagators
    return float(single.observe_one(
        phi.ravel().copy(), g0[:, 0].copy(), g1[:, 0].copy(), system.state[1].copy(),
        system.out[0].copy(), float(system.out_force[0, 0]), float(system.out_input[0]),
        float(direct[0, 0]), float(1.0 / structure.masses[0]), float(system.input[1]),
        segment.input, segment.fine, measured[0], segment.weight[0],
        float(tuned.noise[0] / abs(p.gain[0])), tuned.input_noise, tuned.model_noise, spread,
        table[0], table[1], step, segment.start / segment.sample_rate, segment.skip, keep,
        soften, innovations[0], states, dense[0], expected[0],
    ))  # fmt: skip


SOFTEN = 0.43
"""Samples over which a recorder's filter spreads a jump, one standard deviation [-]."""


def beyond_filter(seen: Observed, fine: int) -> FloatArray:
    """Return what a recorder's filter takes from the predicted samples, (n_sensors, n) array.

    A recorder passes what lies below about 0.46 of its rate; a force with kinks or jumps has
    more.
    """
    if fine == 1:
        return np.zeros_like(seen.expected)
    half = 24 * fine
    taps = scipy.signal.firwin(2 * half + 1, 0.92 / fine, window=("kaiser", 5.0))
    first = 2 * half // fine
    passed = []
    for row in seen.dense:
        padded = np.concatenate([np.full(half, row[0]), row, np.full(half, row[-1])])
        passed.append(
            scipy.signal.upfirdn(taps, padded, 1, fine)[first : first + seen.expected.shape[1]]
        )
    out: FloatArray = seen.expected - np.array(passed)
    return out


def full_segment(prepared: Prepared, index: int, fine: int) -> Segment:
    """Return a whole test as a segment."""
    return Segment(
        index, prepared.name, prepared.sample_rate, fine, 0, prepared.start, prepared.input,
        prepared.measured, prepared.slope, prepared.weight, index, prepared.hold_out,
    )  # fmt: skip


def cut(segment: Segment, start: int, stop: int, skip: int) -> Segment:
    """Return the samples start to stop of a whole test."""
    return replace(
        segment, start=start, skip=skip,
        input=segment.input[start * segment.fine : stop * segment.fine],
        measured=np.ascontiguousarray(segment.measured[:, start:stop]),
        slope=np.ascontiguousarray(segment.slope[:, start:stop]),
        weight=np.ascontiguousarray(segment.weight[:, start:stop]),
    )  # fmt: skip
