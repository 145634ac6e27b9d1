"""Which poles are modes: those without which the measurement is explained measurably worse."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.likelihood import fit
from shakerproc.modal.lines import Lines
from shakerproc.modal.modal_model import ModalFit
from shakerproc.modal.stabilisation import damping_of

FEW_STEPS: Final = 6
"""Steps of the search where two models are only compared."""

MARGIN: Final = 10.0
"""By how much Schwarz' criterion must improve for one more mode: very strong evidence [-]."""

UNKNOWN: Final = 0.4
"""Standard deviation of ln(damping) above which a pole is not taken for a mode [-]."""

LARGEST_DAMPING: Final = 0.25
"""Damping ratio above which a pole is not taken for a mode [-]."""

SMOOTHED: Final = 41
"""Lines over which the noise is smoothed."""

FAR: Final = 3.0
"""Loss of a mode, in prices of a mode, above which it is needed without a closer look [-]."""

NEAR: Final = 0.3
"""Gain of a candidate where it stands, in prices of a mode, from which on it is refined [-]."""

SAME: Final = 0.1
"""Distance of two poles, in units of the smaller damping, below which they are one [-]."""


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
    best = _pruned(lines, fit(lines, apart(certain), FEW_STEPS), band)
    best = _grown(lines, best, doubtful, band, 0.5)
    best = _grown(lines, best, twins(lines, best), band, SAME)
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
        if errors[worst] < UNKNOWN:
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
    share = _share_left(lines, model).mean(axis=0)
    level = np.empty_like(share)
    for own in lines.records:
        level[own] = _smooth(share[own])
    weight = lines.weights / np.sqrt(np.maximum(level, 1e-6 * level.max() + 1e-300))
    return replace(lines, weight=weight / np.sqrt(np.mean(weight**2)))


def _smooth(values: FloatArray) -> FloatArray:
    size = min(SMOOTHED, values.size // 4 * 2 + 1)
    padded = np.pad(values, size // 2, mode="reflect")
    return np.convolve(padded, np.full(size, 1.0 / size), mode="valid")


def _share_left(lines: Lines, model: ModalFit) -> FloatArray:
    """Return the residual of each line over its mean, (n_outputs, n_lines)."""
    left = np.abs(lines.weights * (lines.outputs - model.synthesis)) ** 2
    mean = left.mean(axis=1, keepdims=True)
    return np.asarray(left / np.where(mean > 0.0, mean, 1.0))


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
        if gain < NEAR * price_of(lines):
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
    left = _share_left(lines, model)
    excess, found = left.mean(axis=0) - np.median(left.mean(axis=0)), []
    for pole in model.poles:
        frequency, reach = np.abs(pole) / (2.0 * np.pi), -pole.real / np.pi
        near = np.abs(lines.frequency - frequency) < max(reach, 0.01 * frequency)
        count = int(near.sum()) * left.shape[0]
        if count and excess[near].mean() > 3.0 / np.sqrt(count):
            found += [pole * (1.0 + shift) for shift in (-0.015, 0.015, -0.03, 0.03)]
    return np.array(found, dtype=np.complex128)


def apart(poles: ComplexArray) -> ComplexArray:
    """Return the poles without those that coincide with one before them.

    `poles` are in [rad/s].
    """
    kept: list[complex] = []
    for pole in poles:
        if all(abs(pole - one) > SAME * min(-pole.real, -one.real) for one in kept):
            kept.append(complex(pole))
    return np.array(kept, dtype=np.complex128)


def _sound(model: ModalFit, band: tuple[float, float]) -> bool:
    frequency = np.abs(model.poles) / (2.0 * np.pi)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    damped = (damping_of(model.poles) < LARGEST_DAMPING) & (damping_of(model.poles) > 2e-5)
    return bool((inside & damped).all()) and apart(model.poles).size == model.poles.size


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
    frequency = np.abs(model.poles) / (2.0 * np.pi)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    inside &= (damping_of(model.poles) < LARGEST_DAMPING) & (damping_of(model.poles) > 2e-5)
    kept = apart(model.poles[inside])
    if kept.size < model.poles.size:
        model = fit(lines, kept, FEW_STEPS)
    while model.poles.size:
        weakest = int(np.argmin(model.losses))
        if model.losses[weakest] > FAR * price_of(lines):
            break  # far from needless: no search would make up for it
        smaller = fit(lines, np.delete(model.poles, weakest), FEW_STEPS)
        if _is_better(lines, model, smaller):
            break
        model = smaller
    return model
