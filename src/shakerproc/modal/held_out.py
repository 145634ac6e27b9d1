"""Modes that the rest of a record needs to foretell each part of it; others are parts of one.

A resonance that moves with level or time is fitted better by several poles, however many the
criterion of one fit asks for: their residues make up its path in this record. In another part
of the record they do not, and a mode of the structure does.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.basis import basis_of, rest_of, stacked
from shakerproc.modal.least_squares import orthonormal
from shakerproc.modal.likelihood import fit
from shakerproc.modal.lines import Lines, joined, lines_of_samples, thinned
from shakerproc.modal.modal_model import ModalFit
from shakerproc.modal.selection import FEW_STEPS

REACH: Final = 0.1
"""Relative distance of two poles within which they may be one resonance that moves [-]."""

SHARE: Final = 0.1
"""Share of the larger power of a part's input that another has on both sides of a mode [-];
the parts of a sweep have less, and tell nothing of each other."""

MOST_LINES: Final = 1_000
"""Lines of a part at most."""

N_PARTS: Final = (8, 4, 2)
"""Parts of a record; fewer where more would be too short."""

LEAST_LINES: Final = 100
"""Lines of a part at least: its transient takes one for each mode."""

CHANCE: Final = 0.01
"""Probability that a pole which foretells nothing is taken for a mode [-]; with fewer than
seven parts it is one half to the power of their number."""


def parts_of(
    inputs: FloatArray, responses: FloatArray, sample_rate: float, band: tuple[float, float]
) -> list[Lines]:
    """Return the lines of parts of a record with equal shares of the input's power.

    Parameters
    ----------
    inputs, responses : (n_channels, n_samples) array
        The record [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        Limits [Hz].

    Returns
    -------
    list of Lines
        Empty where even two parts hold too few lines.
    """
    power = np.cumsum(np.sum(inputs**2, axis=0))
    for count in N_PARTS:
        cuts = np.searchsorted(power, power[-1] * np.arange(1, count) / count)
        ends = [0, *(int(cut) for cut in cuts), power.size]
        own = [slice(*both) for both in pairwise(ends)]
        try:
            parts = [
                lines_of_samples(inputs[:, one], responses[:, one], sample_rate, band)
                for one in own
            ]
        except ValueError:  # of a band with fewer than 8 lines
            continue
        if count == N_PARTS[-1] or min(part.frequency.size for part in parts) >= LEAST_LINES:
            return [thinned(part, MOST_LINES) for part in parts]
    return []


def confirmed(lines: Lines, model: ModalFit, parts: Sequence[Lines]) -> ModalFit:
    """Return the model without the modes that foretell a part of the record no better.

    Of every pair of neighbours the weaker mode is asked: it stays only if with it the residues
    of all other parts foretell a part better, by Wilcoxon's test of signed ranks over parts.

    Parameters
    ----------
    lines : Lines
        What the model was fitted to.
    model : ModalFit
        The model.
    parts : sequence of Lines
        From `parts_of`.

    References
    ----------
    .. [1] F. Wilcoxon, "Individual comparisons by ranking methods", Biometrics Bulletin 1,
       80-83, 1945.
    """
    asked: list[complex] = []
    best = model
    while best.poles.size > 1:
        weakest, driven = _next(best, parts, asked)
        if weakest is None:
            break
        asked.append(complex(best.poles[weakest]))
        fewer = fit(lines, np.delete(best.poles, weakest), FEW_STEPS)
        without = foretold(fewer.poles, driven, best.poles)
        gain = without - foretold(best.poles, driven, best.poles)
        if chance_of(gain) > max(CHANCE, 0.5**gain.size):
            best, asked = fewer, []
    return best if best is model else fit(lines, best.poles)


def chance_of(gain: FloatArray) -> float:
    """Return the probability of signed ranks as high as those of gains that are none [-].

    Parameters
    ----------
    gain : (n,) array
        Of each part; few, since all signs are gone through.
    """
    ranks = 1.0 + np.argsort(np.argsort(np.abs(gain)))
    signs = np.arange(2**gain.size)[:, np.newaxis] >> np.arange(gain.size) & 1
    return float(np.mean(signs @ ranks >= ranks[gain > 0.0].sum()))


def _next(
    model: ModalFit, parts: Sequence[Lines], asked: Sequence[complex]
) -> tuple[int | None, list[Lines]]:
    """Return the weakest mode with a neighbour that was not asked about yet, and its parts."""
    poles = model.poles
    apart = np.abs(np.abs(poles)[:, np.newaxis] / np.abs(poles) - 1.0)
    np.fill_diagonal(apart, np.inf)
    for mode in np.argsort(model.losses):
        other = int(np.argmin(apart[mode]))
        if apart[mode, other] < REACH and complex(poles[mode]) not in asked:
            driven = _driven(parts, np.abs(poles[[mode, other]]) / (2.0 * np.pi))
            if len(driven) > 1:
                return int(mode), driven
    return None, []


def _driven(parts: Sequence[Lines], pair: FloatArray) -> list[Lines]:
    """Return the parts whose input reaches both sides of a pair of modes [Hz]."""
    middle = float(pair.mean())
    low, high = middle * (1.0 - REACH), middle * (1.0 + REACH)
    power = np.zeros((len(parts), 2))
    for i, part in enumerate(parts):
        each = np.sum(np.abs(part.inputs) ** 2, axis=0)
        for k, (begin, end) in enumerate(((low, middle), (middle, high))):
            inside = (part.frequency >= begin) & (part.frequency <= end)
            power[i, k] = each[inside].mean() if inside.any() else 0.0
    reached = (power > SHARE * power.max(axis=0, initial=0.0)).all(axis=1)
    return [part for part, kept in zip(parts, reached, strict=True) if kept]


def foretold(poles: ComplexArray, parts: Sequence[Lines], free: ComplexArray) -> FloatArray:
    """Return the deviance of what residues of all other parts foretell of each part [-].

    Parameters
    ----------
    poles : (n_modes,) complex array
        Those of the model [rad/s].
    parts : sequence of Lines
        Parts of a record.
    free : (n,) complex array
        Poles of the decay from the start of a part, which no other part can foretell: the same
        for all models that are compared [rad/s].

    Returns
    -------
    (n_parts,) array
        -2 ln(likelihood), up to a constant.
    """
    whole = joined(parts)
    steady = replace(whole, transient=False)
    columns = _columns(steady, poles)
    columns /= np.linalg.norm(columns, axis=1, keepdims=True)
    targets = stacked(whole.outputs)
    reduced = []
    for part, own in zip(parts, whole.records, strict=True):
        decay = _columns(replace(part, inputs=part.inputs[:0]), free)
        taken, _ = orthonormal((decay / np.linalg.norm(decay, axis=1, keepdims=True)).T)
        rows = np.concatenate([columns, targets])[:, np.tile(own, 2)]
        reduced.append(rows - (rows @ taken) @ taken.T)
    gram = np.array([rows @ rows.T for rows in reduced])
    n = len(columns)
    found = []
    for rows, products in zip(reduced, gram.sum(axis=0) - gram, strict=True):
        residues = np.linalg.lstsq(products[:n, :n], products[:n, n:], rcond=1e-14)[0]
        left = np.mean((rows[n:] - residues.T @ rows[:n]) ** 2, axis=1)
        found.append(rows.shape[1] * np.sum(np.log(np.maximum(left, 1e-300))))
    return np.array(found)


def _columns(lines: Lines, poles: ComplexArray) -> FloatArray:
    """Return all columns of the linear problem for poles, (n_columns, 2 n_lines)."""
    basis = basis_of(lines, poles, rest_of(lines))
    return np.concatenate([basis.columns.reshape(-1, basis.rest.shape[1]), basis.rest])
