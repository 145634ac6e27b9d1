"""The screening: candidates as forces that a linear model lacks, by linear regression.

The innovations of a linear observer are, exactly, what the lacking forces show through it; so
each candidate's force along the measured motion, sent through the same observer, is a column of
a linear regression. Inner parameters are tried on a grid.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from shakerproc.data import FloatArray
from shakerproc.diagnose import kernel
from shakerproc.diagnose.candidates import Candidate, Motion
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Segment,
    Tuning,
    assemble,
    law_table,
    reduced_mass,
    run,
)
from shakerproc.diagnose.structure import Structure, hold, matrices, pattern


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Motion of a segment: displacement and velocity of every mass against the base."""

    displacement: FloatArray
    velocity: FloatArray
    input: FloatArray


def track(
    structure: Structure, hypothesis: Hypothesis, p: Parameters, segment: Segment,
    tuned: Tuning, blend_hz: float,
) -> tuple[Track, FloatArray] | None:  # fmt: skip
    """Return motion and innovations: the observer's below `blend_hz`, integrated above.

    Only masses with an acceleration sensor are integrated; the others follow the observer.
    """
    whole = assemble(structure, hypothesis, p)
    table = law_table(structure, hypothesis, p, whole.masses.size)
    result = run(whole, table, segment, tuned, p, keep=True)
    if result is None:
        return None
    m = whole.masses.size
    displacement, velocity = result.states[:m].copy(), result.states[m:].copy()
    base = segment.input[:: segment.fine]
    n = base.size
    length = next_fast_len(n + 256, real=True)
    omega = 2.0 * np.pi * rfftfreq(length, 1.0 / segment.sample_rate)
    omega[0] = 1.0
    share = (omega / (2.0 * np.pi * blend_hz)) ** 6
    share = share / (1.0 + share)
    share[0] = 0.0
    taper = _taper(n, int(0.05 * segment.sample_rate))
    for i, sensing in enumerate(structure.sensing):
        if sensing.order != 2:
            continue
        measured = (segment.measured[i] + p.delay[i] * segment.slope[i]) / p.gain[i]
        relative = measured - base if structure.forced < 0 and sensing.absolute else measured
        spectrum = rfft(relative * taper, length)
        model = rfft(displacement[sensing.mass] * taper, length)
        motion = share * spectrum / -(omega**2) + (1.0 - share) * model
        inner = taper > 0.999
        z = irfft(motion, length)[:n]
        v = irfft(1j * omega * motion, length)[:n]
        displacement[sensing.mass] = np.where(inner, z, displacement[sensing.mass])
        velocity[sensing.mass] = np.where(inner, v, velocity[sensing.mass])
    return Track(displacement, velocity, base), result.innovations


def part_of(moved: Track, start: int, stop: int) -> Track:
    """Return a stretch of a track."""
    return Track(
        moved.displacement[:, start:stop],
        moved.velocity[:, start:stop],
        moved.input[start:stop],
    )


def _taper(n: int, edge: int) -> FloatArray:
    ramp = 0.5 * (1.0 - np.cos(np.pi * np.arange(edge) / edge))
    out = np.ones(n)
    out[:edge], out[-edge:] = ramp, ramp[::-1]
    return out


@dataclass(frozen=True, slots=True, eq=False)
class Screen:
    """Everything that regressions share: the linear observer, its innovations and columns."""

    structure: Structure
    segments: tuple[Segment, ...]
    tunings: tuple[Tuning, ...]
    tracks: tuple[Track, ...]
    residual: FloatArray
    base: FloatArray


def stretch(structure: Structure, joint: int, moved: Track) -> tuple[FloatArray, FloatArray]:
    """Return relative displacement and velocity of a joint along a track."""
    row = pattern(structure.joints[joint], moved.displacement.shape[0])
    return row @ moved.displacement, row @ moved.velocity


def through(screen: Screen, forces: list[list[FloatArray]], row: FloatArray) -> FloatArray:
    """Return whitened columns (n_columns, n) of forces on the masses of `row`.

    forces[segment][column] is an array; row (n_masses,) says on which masses it acts, with
    which sign.
    """
    parts = []
    structure = screen.structure
    system = matrices(structure)
    for segment, own in zip(screen.segments, forces, strict=True):
        tuned = screen.tunings[segment.gain_key]
        phi, g0, g1 = hold(system.state, system.force, 1.0 / segment.sample_rate)
        f = np.stack([np.outer(row, force) for force in own])
        columns = np.empty((len(own), len(structure.sensing), f.shape[2]))
        kernel.filter_forces(phi, g0, g1, system.out, system.out_force, tuned.gain, f, columns)
        columns /= tuned.sigma[:, None]
        parts.append(columns[:, :, segment.skip :].reshape(len(own), -1))
    return np.concatenate(parts, axis=1)


def prepare_screen(
    structure: Structure,
    p: Parameters,
    whole: tuple[Segment, ...],
    segments: tuple[Segment, ...],
    tunings: tuple[Tuning, ...], blend_hz: float,
) -> Screen | None:  # fmt: skip
    """Return the common part of every regression around a linear model."""
    linear = structure.with_linear(p.stiffness, p.damping)
    tracks, parts = [], []
    none = Hypothesis()
    known: dict[int, tuple[Track, FloatArray]] = {}
    for segment in segments:
        tuned = tunings[segment.gain_key]
        if segment.test not in known:
            found = track(linear, none, p, whole[segment.test], tuned, blend_hz)
            if found is None:
                return None
            known[segment.test] = found
        moved, innovations = known[segment.test]
        stop = segment.start + segment.measured.shape[1]
        tracks.append(part_of(moved, segment.start, stop))
        judged = innovations[:, segment.start + segment.skip : stop]
        parts.append(judged.ravel())
    screen = Screen(
        linear, segments, tunings, tuple(tracks), np.concatenate(parts),
        np.empty((0, 0)),
    )  # fmt: skip
    columns = []
    for joint in range(len(structure.joints)):
        forces = []
        for moved in tracks:
            d, v = stretch(linear, joint, moved)
            forces.append([d * p.stiffness[joint], v * p.damping[joint]])
        columns.append(
            through(screen, forces, pattern(structure.joints[joint], linear.masses.size))
        )
    base = np.concatenate(columns)
    return replace(screen, base=base)


@dataclass(frozen=True, slots=True)
class Part:
    """One candidate of a start, with its numbers and others to try."""

    candidate: Candidate
    joint: int
    values: tuple[float, ...]
    guesses: tuple[tuple[float, ...], ...]
    motion: Motion


@dataclass(frozen=True, slots=True)
class Start:
    """Where a fit of one candidate or of two may start, and the regression's gain there."""

    parts: tuple[Part, ...]
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    gain: float

    @property
    def last(self) -> Part:
        """The only candidate, or that of the two with guesses of its own."""
        return self.parts[-1]


class Regression:
    """The regression on the linear model's own columns."""

    def __init__(self, screen: Screen) -> None:
        self.structure = screen.structure
        self.base = screen.base
        self.inverse = np.linalg.pinv(self.base @ self.base.T, rcond=1e-13)
        self.weights = self.inverse @ (self.base @ screen.residual)
        self.left = screen.residual - self.weights @ self.base
        self.cost = float(self.left @ screen.residual)


def motion_scales(screen: Screen, joint: int, sample_rate: float) -> Motion:
    """Return the scales of the motion in a joint."""
    peak, square, fast, n = 0.0, 0.0, 0.0, 0
    for moved in screen.tracks:
        d, v = stretch(screen.structure, joint, moved)
        peak = max(peak, float(np.max(np.abs(d))))
        square += float(d @ d)
        fast += float(v @ v)
        n += d.size
    own = screen.structure.joints[joint]
    accelerated = float(
        np.sqrt(np.mean([screen.tunings[x.gain_key].rms ** 2 for x in screen.segments]))
    )
    rms, quick = np.sqrt(square / n), np.sqrt(fast / n)
    return Motion(
        peak, float(rms), float(quick), own.stiffness, own.damping,
        reduced_mass(screen.structure, own), float(quick / rms / (2.0 * np.pi)), 0.0,
        reduced_mass(screen.structure, own) * accelerated,
    )  # fmt: skip


def law_columns(
    screen: Screen, joint: int, rows: list[tuple[int, tuple[float, ...]]]
) -> FloatArray:
    """Return the columns of laws in a joint, each an op and its numbers."""
    forces = []
    for segment, moved in zip(screen.segments, screen.tracks, strict=True):
        d, v = stretch(screen.structure, joint, moved)
        own = []
        for op, numbers in rows:
            p = np.array([[*numbers, *[0.0] * (8 - len(numbers))]])
            force = np.empty(d.size)
            step = 1.0 / segment.sample_rate
            kernel.force_along(op, p, d, v, segment.start * step, step, force)
            own.append(force)
        forces.append(own)
    row = pattern(screen.structure.joints[joint], screen.structure.masses.size)
    return through(screen, forces, row)


def attached_columns(
    screen: Screen, joint: int, inners: list[tuple[float, ...]]
) -> FloatArray | None:
    """Return columns of attached modes of 1 kg, each of a frequency [Hz] and a damping ratio.

    None where no accelerometer stands on their mass.
    """
    mass = screen.structure.joints[joint].b
    at = next(
        (i for i, s in enumerate(screen.structure.sensing) if s.mass == mass and s.order == 2),
        None,
    )
    if at is None:
        return None
    row = np.zeros(screen.structure.masses.size)
    row[mass] = 1.0
    forces = []
    for segment, moved in zip(screen.segments, screen.tracks, strict=True):
        n = moved.displacement.shape[1]
        length = next_fast_len(n + 512, real=True)
        omega = 2.0 * np.pi * rfftfreq(length, 1.0 / segment.sample_rate)
        absolute = rfft(segment.measured[at], length)
        own_forces = []
        for frequency, ratio in inners:
            own = 2.0 * np.pi * frequency
            top = own**2 + 2j * ratio * own * omega
            own_forces.append(irfft(absolute * top / (top - omega**2), length)[:n])
        forces.append(own_forces)
    return through(screen, forces, row)
