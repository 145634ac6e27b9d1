"""The screening sheet: every candidate's columns once, then the best alone and in pairs.

All columns are freed of what the linear model explains and brought to length one; the table of
their products then gives the gain of any pair without touching the samples again.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnose.candidates import Candidate, Motion, library
from shakerproc.diagnose.screen import (
    Part,
    Regression,
    Screen,
    Start,
    attached_columns,
    law_columns,
    motion_scales,
)

SHARES = np.geomspace(0.4, 3.0, 40)
"""Frequencies of an attached mode to try, over that of the motion [-]."""
ATTACHED_RATIO = 0.02
"""Damping ratio of an attached mode in the screening [-]."""
NOTHING = 1e-6
"""Share of a column below which the linear model is taken to hold all of it [-]."""
FAMILIES = (
    {"gap", "offset_gap", "stop"},
    {"coulomb_friction", "stribeck_friction", "lugre_friction"},
    {"jenkins", "iwan", "bouc_wen"},
    {"power_law", "cubic_stiffness"},
    {"power_law", "quadratic_stiffness"},
)
"""Candidates of which two in one joint are but a richer law of one kind."""
ALIKE = 0.9995
"""Cosine above which two columns are one [-]."""


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """One candidate in one joint at one point of its grid; its columns in the sheet."""

    candidate: Candidate
    joint: int
    motion: Motion
    inner: tuple[float, ...]
    columns: slice


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Products of all columns, each of length one and free of the linear model.

    Attributes
    ----------
    regression : Regression
        The linear model's.
    entries : tuple of Entry
        What the columns are.
    gram : (n, n) array
        Cosines between columns.
    right : (n,) array
        Products with what the linear model leaves.
    length : (n,) array
        Length of every column before; 0 where the linear model holds all of it.
    shared : (n, n_base) array
        What of the linear columns each of them held, before.
    """

    regression: Regression
    entries: tuple[Entry, ...]
    gram: FloatArray
    right: FloatArray
    length: FloatArray
    shared: FloatArray


def make_sheet(screen: Screen, regression: Regression, joints: Sequence[int]) -> Sheet:
    """Return the sheet of every candidate in these joints."""
    jobs = []
    for joint in joints:
        motion = motion_scales(screen, joint, screen.segments[0].sample_rate)
        for candidate in library(motion):
            jobs.append((candidate, joint, motion))

    def work(job: tuple[Candidate, int, Motion]):  # type: ignore[no-untyped-def]
        candidate, joint, motion = job
        inners, columns, width = _columns_of(screen, candidate, joint, motion)
        if not inners:
            return job, [], None
        unit, shared, length = freed(columns, regression)
        right = unit @ regression.left
        return job, inners, (unit.astype(np.float32), shared, length, right, width)

    with ThreadPoolExecutor(2) as pool:
        results = [one for one in pool.map(work, jobs) if one[2] is not None]
    entries, at = [], 0
    for (candidate, joint, motion), inners, found in results:
        for inner in inners:
            entries.append(Entry(candidate, joint, motion, inner, slice(at, at + found[4])))
            at += found[4]
    columns = np.concatenate([found[0] for _, _, found in results])
    shared, length, right = (
        np.concatenate([found[i] for _, _, found in results]) for i in (1, 2, 3)
    )
    gram = (columns @ columns.T).astype(float)
    return Sheet(regression, tuple(entries), gram, right, length, shared)


def freed(
    columns: FloatArray, regression: Regression
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return columns without what the linear model holds of them, each of length one.

    Besides them what of the linear columns they held, and their lengths before; columns that
    it holds altogether have length 0.
    """
    before = np.linalg.norm(columns, axis=1)
    shared = columns @ regression.base.T @ regression.inverse
    left = columns - shared @ regression.base
    length = np.linalg.norm(left, axis=1)
    length[length < NOTHING * before] = 0.0
    return left / np.where(length > 0.0, length, np.inf)[:, None], shared, length


def _columns_of(
    screen: Screen, candidate: Candidate, joint: int, motion: Motion
) -> tuple[list[tuple[float, ...]], FloatArray, int]:
    """Return the grid of a candidate, its columns (n_grid * width, n) and their width."""
    if candidate.kind == "attached_mode":
        inners: list[tuple[float, ...]] = [
            (float(share * motion.frequency), ATTACHED_RATIO) for share in SHARES
        ]
        columns = attached_columns(screen, joint, inners)
        return ([], np.empty((0, 0)), 1) if columns is None else (inners, columns, 1)
    inners = candidate.grid(motion)
    beside = motion.mass if candidate.kind == "lugre_friction" else motion.stiffness
    rows = [candidate.columns(inner, beside) for inner in inners]
    return (
        inners,
        law_columns(screen, joint, [row for own in rows for row in own]),
        len(rows[0]),
    )


def singles(sheet: Sheet) -> list[Start]:
    """Return the best start of every candidate in every joint, best first."""
    best: dict[tuple[int, int], Start] = {}
    for entry in sheet.entries:
        own = entry.columns
        if not np.all(sheet.length[own] > 0.0):
            continue
        size = own.stop - own.start
        solved = np.linalg.solve(sheet.gram[own, own] + 1e-10 * np.eye(size), sheet.right[own])
        values = _values(entry, solved / sheet.length[own])
        key, gain = (id(entry.candidate), entry.joint), float(solved @ sheet.right[own])
        if values is None or not np.isfinite(gain):
            continue
        if key not in best or gain > best[key].gain:
            best[key] = _start(sheet, [(entry, values, solved / sheet.length[own])], gain)
    for entry in sheet.entries:
        key, more = (id(entry.candidate), entry.joint), entry.candidate.guesses(entry.motion)
        if key not in best and more:
            best[key] = _start(sheet, [(entry, more[0], None)], 0.0)
    return sorted(best.values(), key=lambda start: -start.gain)


def pairs(sheet: Sheet) -> list[Start]:
    """Return the best start of every two candidates (in any joints), best first.

    Every point of one grid is set beside every point of the other; candidates with several
    columns stand aside.
    """
    simple = [
        e for e in sheet.entries
        if e.columns.stop - e.columns.start == 1
        and sheet.length[e.columns.start] > 0.0
    ]  # fmt: skip
    if not simple:
        return []
    at = np.array([e.columns.start for e in simple])
    cosine, right = sheet.gram[np.ix_(at, at)], sheet.right[at]
    rest = np.where(np.abs(cosine) < ALIKE, 1.0 - cosine**2, np.inf)
    weight = (right[:, None] - cosine * right[None, :]) / rest  # of the row's column
    positive = np.array([e.candidate.positive[0] for e in simple])
    allowed = (weight > 0.0) | ~positive[:, None]
    gain = np.where(allowed & allowed.T, weight * right[:, None] + weight.T * right, -np.inf)
    groups: dict[tuple[int, int], list[int]] = {}
    for i, entry in enumerate(simple):
        groups.setdefault((id(entry.candidate), entry.joint), []).append(i)
    found, members = [], list(groups.values())
    for a, first in enumerate(members):
        for second in members[a + 1 :]:
            if _one_kind(simple[first[0]], simple[second[0]]):
                continue
            part = gain[np.ix_(first, second)]
            i, j = divmod(int(np.argmax(part)), part.shape[1])
            if not part[i, j] > 0.0:
                continue
            chosen = []
            for one, other in ((first[i], second[j]), (second[j], first[i])):
                own = np.array([weight[one, other] / sheet.length[at[one]]])
                values = _values(simple[one], own)
                if values is not None:
                    chosen.append((simple[one], values, own))
            if len(chosen) == 2:
                # whatever has guesses of its own (friction) goes last
                chosen.sort(key=lambda c: bool(c[0].candidate.guesses(c[0].motion)))
                found.append(_start(sheet, chosen, float(part[i, j])))
    return sorted(found, key=lambda start: -start.gain)


def _one_kind(one: Entry, other: Entry) -> bool:
    kinds = {one.candidate.kind, other.candidate.kind}
    return one.joint == other.joint and any(kinds <= family for family in FAMILIES)


def _values(entry: Entry, weights: FloatArray) -> tuple[float, ...] | None:
    values = entry.candidate.combine(entry.inner, weights, entry.motion)
    # a number of exactly 0 has no scale to be fitted on
    return None if values is None or not all(values) else tuple(float(v) for v in values)


def _start(sheet: Sheet, chosen: list, gain: float) -> Start:  # type: ignore[type-arg]
    """Return the start of entries with values and weights, and the linear numbers then."""
    base = sheet.regression.weights.copy()
    for entry, _, weights in chosen:
        if weights is not None:
            base -= weights @ sheet.shared[entry.columns]
    structure = sheet.regression.structure
    n = len(structure.joints)
    linear = np.maximum(1.0 + base[: 2 * n].reshape(n, 2), 0.05)
    parts = tuple(
        Part(e.candidate, e.joint, values, tuple(e.candidate.guesses(e.motion)), e.motion)
        for e, values, _ in chosen
    )
    return Start(
        parts, tuple(map(float, structure.stiffness * linear[:, 0])),
        tuple(map(float, structure.damping * linear[:, 1])), gain,
    )  # fmt: skip
