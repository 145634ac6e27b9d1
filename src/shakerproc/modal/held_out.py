"""Modes that one part of a record needs to foretell another; others are parts of one resonance.

A resonance that moves with level or time is fitted better by several poles, however many the
criterion of one fit asks for: their residues make up its path in this record. In another part
of the record they do not, and a mode of the structure does.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.likelihood import fit
from shakerproc.modal.lines import Lines, lines_of_samples, thinned
from shakerproc.modal.modal_model import Fit, response_functions
from shakerproc.modal.selection import FEW_STEPS

REACH: Final = 0.1
"""Relative distance of two poles within which they may be one resonance that moves [-]."""

SHARE: Final = 0.1
"""Share of the larger power of a part's input that the other has on both sides of a mode [-];
the parts of a sweep have less, and tell nothing of each other."""

MOST_LINES: Final = 4_000
"""Lines of a part at most."""


def parts_of(
    inputs: FloatArray, responses: FloatArray, sample_rate: float, band: tuple[float, float]
) -> list[Lines]:
    """Return the lines of two parts of a record with half of the input's power each.

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
        Empty where a part holds too few lines.
    """
    power = np.cumsum(np.sum(inputs**2, axis=0))
    middle = int(np.searchsorted(power, 0.5 * power[-1]))
    parts = []
    for own in (slice(None, middle), slice(middle, None)):
        try:
            lines = lines_of_samples(inputs[:, own], responses[:, own], sample_rate, band)
        except ValueError:
            return []
        parts.append(thinned(lines, MOST_LINES))
    return parts


def confirmed(lines: Lines, model: Fit, parts: Sequence[Lines]) -> Fit:
    """Return the model without the modes that a part does not need to foretell the other.

    Parameters
    ----------
    lines : Lines
        What the model was fitted to.
    model : Fit
        The model.
    parts : sequence of Lines
        From `parts_of`.
    """
    if not parts:
        return model
    asked: list[complex] = []
    best = model
    while best.poles.size > 1:
        weakest = _next(best, parts, asked)
        if weakest is None:
            break
        asked.append(complex(best.poles[weakest]))
        fewer = fit(lines, np.delete(best.poles, weakest), FEW_STEPS)
        without = foretold(fewer.poles, parts, best.poles)
        if (without <= foretold(best.poles, parts, best.poles)).any():
            best, asked = fewer, []
    return best if best is model else fit(lines, best.poles)


def _next(model: Fit, parts: Sequence[Lines], asked: Sequence[complex]) -> int | None:
    """Return the weakest mode that has a neighbour and was not asked about yet."""
    poles = model.poles
    apart = np.abs(np.abs(poles)[:, np.newaxis] / np.abs(poles) - 1.0)
    np.fill_diagonal(apart, np.inf)
    for mode in np.argsort(model.losses):
        other = int(np.argmin(apart[mode]))
        if apart[mode, other] < REACH and complex(poles[mode]) not in asked:
            pair = np.abs(poles[[mode, other]]) / (2.0 * np.pi)
            if _driven(parts, pair):
                return int(mode)
    return None


def _driven(parts: Sequence[Lines], pair: FloatArray) -> bool:
    """Return whether the input reaches both sides of a pair of modes [Hz] in both parts."""
    middle = float(pair.mean())
    low, high = middle * (1.0 - REACH), middle * (1.0 + REACH)
    power = np.empty((2, 2))
    for i, part in enumerate(parts):
        each = np.sum(np.abs(part.inputs) ** 2, axis=0)
        for k, (begin, end) in enumerate(((low, middle), (middle, high))):
            inside = (part.frequency >= begin) & (part.frequency <= end)
            power[i, k] = each[inside].mean() if inside.any() else 0.0
    return bool((power.min(axis=0) > SHARE * power.max(axis=0)).all())


def foretold(poles: ComplexArray, parts: Sequence[Lines], free: ComplexArray) -> FloatArray:
    """Return the deviance of what residues of each part foretell of the other, (2,) array [-].

    `poles` are those of the model and `free` those of the decay from the start of a part,
    which no other part can foretell: the same for all models that are compared [rad/s].
    """
    found = []
    for known, other in zip(parts, reversed(parts), strict=True):
        functions = response_functions(fit(known, poles, 0), other.frequency)
        left = other.outputs - np.einsum("oif,if->of", functions, other.inputs)
        alone = replace(other, inputs=other.inputs[:0], outputs=left)
        found.append(fit(alone, free, 0).deviance)
    return np.array(found)
