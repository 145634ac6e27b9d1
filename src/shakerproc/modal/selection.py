"""Which poles are modes: without them the record, or a part held out, is explained worse.

A resonance that moves with level or time is fitted better by several poles, however many the
criterion of one fit asks for: their residues make up its path in this record. In another part
of the record they do not, and a mode of the structure does.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.likelihood import fit, orthonormal
from shakerproc.modal.lines import Lines, joined, lines_of_samples, thinned
from shakerproc.modal.modal_model import ModalFit, basis_of, rest_of, stacked
from shakerproc.modal.stabilisation import damping_of

FEW_STEPS: Final = 6
"""Steps of the search where two models are only compared."""

MARGIN: Final = 10.0
"""By how much Schwarz' criterion must improve for one more mode: very strong evidence [-]."""

UNKNOWN_DAMPING: Final = 0.4
"""Standard deviation of ln(damping) above which a pole is not taken for a mode [-]."""

LARGEST_DAMPING: Final = 0.25
"""Damping ratio above which a pole is not taken for a mode [-]."""

SMOOTHED_LINES: Final = 41
"""Lines over which the noise is smoothed."""

NEEDED_LOSS: Final = 3.0
"""Loss of a mode, in prices of a mode, above which it is needed without a closer look [-]."""

LEAST_GAIN: Final = 0.3
"""Gain of a candidate where it stands, in prices of a mode, from which on it is refined [-]."""

SAME_POLE: Final = 0.1
"""Distance of two poles, in units of the smaller damping, below which they are one [-]."""

SAME_RESONANCE: Final = 0.1
"""Relative distance of two poles within which they may be one resonance that moves [-]."""

DRIVEN_SHARE: Final = 0.1
"""Share of the larger power of a part's input that another has on both sides of a mode [-];
the parts of a sweep have less, and tell nothing of each other."""

MOST_LINES: Final = 1_000
"""Lines of a part at most."""

N_PARTS: Final = (8, 4, 2)
"""Parts of a record; fewer where more would be too short."""

LEAST_LINES: Final = 100
"""Lines of a part at least: its transient takes one for each mode."""

FALSE_MODES: Final = 0.01
"""Probability that a pole which foretells nothing is taken for a mode [-]; with fewer than
seven parts it is one half to the power of their number."""


def selected(
    lines: Lines, certain: ComplexArray, doubtful: ComplexArray, band: tuple[float, float]
) -> tuple[Lines, ModalFit]:
    """Return the modal model whose every mode is needed, and the lines weighted for it.

    Parameters
    ----------
    lines : Lines
        What is fitted.
    certain : (n,) complex array
        Poles that stay over many orders [rad/s].
    doubtful : (m,) complex array
        Poles that stay over a few; tried one by one [rad/s].
    band : (float, float)
        Where a mode may lie [Hz].

    Returns
    -------
    Lines
        With weights by the noise that the model leaves.
    Fit
        Refined; without modes where none is needed.

    References
    ----------
    .. [1] R. E. Kass and A. E. Raftery, "Bayes factors", J. American Statistical Association
       90, 773-795, 1995.
    """
    best = _pruned(lines, fit(lines, distinct_poles(certain), FEW_STEPS), band)
    best = _grown(lines, best, doubtful, band, 0.5)
    best = _grown(lines, best, twins(lines, best), band, SAME_POLE)
    if not best.poles.size:
        return lines, best
    weighted = reweighted(lines, best)
    best = _pruned(weighted, fit(weighted, best.poles, FEW_STEPS), band)
    more = _grown(weighted, best, np.concatenate([certain, doubtful]), band, 0.5)
    if more.poles.size > best.poles.size:  # what louder noise elsewhere had hidden
        best, weighted = more, reweighted(lines, more)
    return weighted, _certain(weighted, _pruned(weighted, fit(weighted, best.poles), band))


def _certain(lines: Lines, model: ModalFit) -> ModalFit:
    """Return the model without modes whose damping it does not know at all."""
    while model.poles.size:
        errors = np.sqrt(np.diag(model.covariance))[::2]
        errors = np.where(damping_of(model.poles) > LARGEST_DAMPING, np.inf, errors)
        worst = int(np.argmax(errors))
        if errors[worst] < UNKNOWN_DAMPING:
            break
        model = fit(lines, np.delete(model.poles, worst))
    return model


def reweighted(lines: Lines, model: ModalFit) -> Lines:
    """Return the lines with weights that make the noise of a model white.

    Parameters
    ----------
    lines : Lines
        What was fitted.
    model : ModalFit
        Its model: what it leaves, smoothed over lines, is the noise.
    """
    share = _residual_share(lines, model).mean(axis=0)
    level = np.empty_like(share)
    for record in lines.records:
        level[record] = _smooth(share[record])
    weight = lines.weights / np.sqrt(np.maximum(level, 1e-6 * level.max() + 1e-300))
    return replace(lines, weight=weight / np.sqrt(np.mean(weight**2)))


def _smooth(values: FloatArray) -> FloatArray:
    size = min(SMOOTHED_LINES, values.size // 4 * 2 + 1)
    padded = np.pad(values, size // 2, mode="reflect")
    return np.convolve(padded, np.full(size, 1.0 / size), mode="valid")


def _residual_share(lines: Lines, model: ModalFit) -> FloatArray:
    """Return the residual of each line over its mean, (n_outputs, n_lines)."""
    residual = np.abs(lines.weights * (lines.outputs - model.synthesis)) ** 2
    mean = residual.mean(axis=1, keepdims=True)
    return np.asarray(residual / np.where(mean > 0.0, mean, 1.0))


def _grown(
    lines: Lines, model: ModalFit, more: ComplexArray, band: tuple[float, float], reach: float
) -> ModalFit:
    """Return the model with those of some further poles that it needs.

    A pole within `reach` half-widths of a mode is taken for that mode.
    """
    for pole in more:
        if np.any(np.abs(model.poles - pole) < reach * -model.poles.real):
            continue
        larger = np.append(model.poles, pole)
        gain = model.deviance - fit(lines, larger, 0).deviance
        if gain < LEAST_GAIN * price_of(lines):
            continue
        trial = fit(lines, larger, FEW_STEPS)
        if _is_better(lines, trial, model) and _sound(trial, band):
            model = trial
    return model


def twins(lines: Lines, model: ModalFit) -> ComplexArray:
    """Return where a second mode may hide beside one: its band is left with more than noise.

    Parameters
    ----------
    lines : Lines
        What is fitted.
    model : ModalFit
        Its model.

    Returns
    -------
    (n,) complex array
        Poles to begin from, 1 and 3 % to either side [rad/s].
    """
    residual = _residual_share(lines, model)
    excess, starts = residual.mean(axis=0) - np.median(residual.mean(axis=0)), []
    for pole in model.poles:
        frequency, reach = np.abs(pole) / (2.0 * np.pi), -pole.real / np.pi
        near = np.abs(lines.frequency - frequency) < max(reach, 0.01 * frequency)
        count = int(near.sum()) * residual.shape[0]
        # squares of complex noise scatter as much as their mean, which is 1: three deviations
        if count and excess[near].mean() > 3.0 / np.sqrt(count):
            starts += [pole * (1.0 + shift) for shift in (-0.015, 0.015, -0.03, 0.03)]
    return np.array(starts, dtype=np.complex128)


def distinct_poles(poles: ComplexArray) -> ComplexArray:
    """Return the poles without those that coincide with one before them.

    `poles` are in [rad/s].
    """
    kept: list[complex] = []
    for pole in poles:
        if all(abs(pole - one) > SAME_POLE * min(-pole.real, -one.real) for one in kept):
            kept.append(complex(pole))
    return np.array(kept, dtype=np.complex128)


def _sound(model: ModalFit, band: tuple[float, float]) -> bool:
    distinct = distinct_poles(model.poles).size == model.poles.size
    return bool(_plausible(model.poles, band).all()) and distinct


def _plausible(poles: ComplexArray, band: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which poles [rad/s] lie in a band [Hz] with a damping that a mode may have."""
    frequency = np.abs(poles) / (2.0 * np.pi)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    return inside & (damping_of(poles) < LARGEST_DAMPING) & (damping_of(poles) > 2e-5)


def price_of(lines: Lines) -> float:
    """Return the penalty of Schwarz' criterion for one more mode."""
    n_inputs = lines.inputs.shape[0]
    n_each = 2 + lines.outputs.shape[0] * 2 * (n_inputs + lines.n_transients)
    return float(n_each * np.log(2 * lines.outputs.size))


def _is_better(lines: Lines, larger: ModalFit, smaller: ModalFit) -> bool:
    n_values = 2 * lines.outputs.size
    return bool(larger.criterion(n_values) < smaller.criterion(n_values) - MARGIN)


def _pruned(lines: Lines, model: ModalFit, band: tuple[float, float]) -> ModalFit:
    """Return the model without the modes that it does not need."""
    kept = distinct_poles(model.poles[_plausible(model.poles, band)])
    if kept.size < model.poles.size:
        model = fit(lines, kept, FEW_STEPS)
    while model.poles.size:
        weakest = int(np.argmin(model.losses))
        if model.losses[weakest] > NEEDED_LOSS * price_of(lines):
            break  # far from needless: no search would make up for it
        smaller = fit(lines, np.delete(model.poles, weakest), FEW_STEPS)
        if _is_better(lines, model, smaller):
            break
        model = smaller
    return model


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
        ranges = [slice(*both) for both in pairwise(ends)]
        try:
            parts = [
                lines_of_samples(inputs[:, one], responses[:, one], sample_rate, band)
                for one in ranges
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
        without = predicted_deviance(fewer.poles, driven, best.poles)
        gain = without - predicted_deviance(best.poles, driven, best.poles)
        if chance_of(gain) > max(FALSE_MODES, 0.5**gain.size):
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
    spacing = np.abs(np.abs(poles)[:, np.newaxis] / np.abs(poles) - 1.0)
    np.fill_diagonal(spacing, np.inf)
    for mode in np.argsort(model.losses):
        other = int(np.argmin(spacing[mode]))
        if spacing[mode, other] < SAME_RESONANCE and complex(poles[mode]) not in asked:
            driven = _driven(parts, np.abs(poles[[mode, other]]) / (2.0 * np.pi))
            if len(driven) > 1:
                return int(mode), driven
    return None, []


def _driven(parts: Sequence[Lines], pair: FloatArray) -> list[Lines]:
    """Return the parts whose input reaches both sides of a pair of modes [Hz]."""
    middle = float(pair.mean())
    low, high = middle * (1.0 - SAME_RESONANCE), middle * (1.0 + SAME_RESONANCE)
    power = np.zeros((len(parts), 2))
    for i, part in enumerate(parts):
        each = np.sum(np.abs(part.inputs) ** 2, axis=0)
        for k, (begin, end) in enumerate(((low, middle), (middle, high))):
            inside = (part.frequency >= begin) & (part.frequency <= end)
            power[i, k] = each[inside].mean() if inside.any() else 0.0
    reached = (power > DRIVEN_SHARE * power.max(axis=0, initial=0.0)).all(axis=1)
    return [part for part, kept in zip(parts, reached, strict=True) if kept]


def predicted_deviance(
    poles: ComplexArray, parts: Sequence[Lines], free: ComplexArray
) -> FloatArray:
    """Return the deviance of each part from its prediction by residues of all others [-].

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
    for part, record in zip(parts, whole.records, strict=True):
        decay = _columns(replace(part, inputs=part.inputs[:0]), free)
        taken, _ = orthonormal((decay / np.linalg.norm(decay, axis=1, keepdims=True)).T)
        rows = np.concatenate([columns, targets])[:, np.tile(record, 2)]
        reduced.append(rows - (rows @ taken) @ taken.T)
    # sums of all parts less those of one are the normal equations without that part
    gram = np.array([rows @ rows.T for rows in reduced])
    n = len(columns)
    deviances = []
    for rows, products in zip(reduced, gram.sum(axis=0) - gram, strict=True):
        residues = np.linalg.lstsq(products[:n, :n], products[:n, n:], rcond=1e-14)[0]
        residual = np.mean((rows[n:] - residues.T @ rows[:n]) ** 2, axis=1)
        deviances.append(rows.shape[1] * np.sum(np.log(np.maximum(residual, 1e-300))))
    return np.array(deviances)


def _columns(lines: Lines, poles: ComplexArray) -> FloatArray:
    """Return all columns of the linear problem for poles, (n_columns, 2 n_lines)."""
    basis = basis_of(lines, poles, rest_of(lines))
    return np.concatenate([basis.columns.reshape(-1, basis.rest.shape[1]), basis.rest])
