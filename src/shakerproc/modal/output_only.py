"""Modes where no input was measured: covariance-driven stochastic subspace identification."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.identification import orders_of
from shakerproc.modal.modal_model import NORMAL_95, ModeSet, Settings
from shakerproc.modal.shapes import (
    normalised,
    phase_collinearity,
    scaled_to,
    without_chance,
)
from shakerproc.modal.stabilisation import (
    Diagram,
    OrderPoles,
    Tolerances,
    are_requested,
    candidates,
    damping_of,
    diagram_of,
    frequency_of,
    requested_poles,
    unit_shapes,
)
from shakerproc.numerals import numeral

BLOCKS: Final = 12
"""Blocks of the record, each left out once for the intervals."""

HIGHEST_OVER_BAND: Final = 1.1
"""Where the analysed samples end, over the end of the band [-]. The input has to be broadband
up to there: where it ends below, its edge looks like damped modes."""

ROWS: Final = 160
"""Size of the block Hankel matrix at most: of 8 responses it reaches 20 samples of the slower
record, with 2.2 to a period of the highest frequency. Longer lags hold more noise than modes:
with 480 a fifth fewer modes are within 1 % and 10 % (`python -m benchmarks.modal`)."""

TOLERANCES: Final = Tolerances(0.01, 0.3, 0.9)
"""How little a stable pole may change; looser than with a measured input."""

KEPT_ORDERS: Final = 3
"""A mode stays over one in so many of the orders."""

TONE_DAMPING: Final = 1e-3
"""Damping ratio below which a pole may be a tone [-]."""

UNKNOWN_DAMPING: Final = 0.8
"""Standard deviation of ln(damping) above which a pole is not taken for a mode [-]."""

MOST_DAMPING: Final = 0.1
"""Damping above which a pole is not taken for a mode of the structure [-]."""

LEAST_COLLINEARITY: Final = 0.6
"""Phase collinearity below which a pole is not taken for a mode of the structure [-]."""


def jackknife(
    others: Sequence[Sequence[OrderPoles]],
    diagram: Diagram,
    poles: ComplexArray,
    shapes: ComplexArray,
    scale: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the scatter of modes over fits that each leave out a block of the record.

    A mode is looked for again at the orders at which the whole record has shown it.

    Parameters
    ----------
    others : sequence of sequences of OrderPoles
        For each block that is left out, fits of every order.
    diagram : Diagram
        Of the whole record.
    poles : (n_modes,) complex array
        Modes of the whole record [rad/s].
    shapes : (n_modes, n_responses) complex array
        Theirs, turned to their mean phase [-].
    scale : (n_responses,) array
        What the shapes of the fits are to be multiplied with [-].

    Returns
    -------
    errors : (2, n_modes) array
        Standard deviations of ln damping and ln frequency [-].
    chance : (n_modes, n_responses) array
        Variances of the imaginary parts of the shapes [-].

    References
    ----------
    .. [1] B. Efron and C. Stein, "The jackknife estimate of variance", Annals of Statistics 9,
       586-596, 1981.
    """
    values = np.empty((len(others), 2, poles.size))
    turned = np.empty((len(others), *shapes.shape), dtype=np.complex128)
    for block, fits in enumerate(others):
        whole, again = _again(fits, diagram, poles)
        values[block] = np.log(damping_of(whole)), np.log(frequency_of(whole))
        turned[block] = scaled_to(normalised(again * scale), shapes)
    if not others:
        return np.zeros((2, 0)), np.zeros(shapes.shape)
    share = (len(others) - 1) / len(others)
    errors = np.sqrt(share * np.sum((values - values.mean(axis=0)) ** 2, axis=0))
    imaginary = turned.imag
    chance = share * np.sum((imaginary - imaginary.mean(axis=0)) ** 2, axis=0)
    return np.asarray(errors), np.asarray(chance)


def _again(
    fits: Sequence[OrderPoles], diagram: Diagram, poles: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return poles and shapes of modes in other fits, at the orders at which each was found.

    Not a number, and no shape, where no such order has a pole.
    """
    stable = np.flatnonzero(diagram.stable)
    poles_again: list[complex] = []
    shapes: list[ComplexArray] = []
    for pole in poles:
        nearest = stable[np.argmin(np.abs(diagram.poles[stable] - pole))]
        number = diagram.cluster[nearest]
        there = diagram.order[diagram.cluster == number] if number >= 0 else []
        orders = {*there, diagram.order[nearest]}
        usable = [fit for fit in fits if fit.order in orders and fit.poles.size]
        if not usable:
            poles_again.append(complex(np.nan, np.nan))
            shapes.append(np.zeros(diagram.shapes.shape[1], dtype=np.complex128))
            continue
        near = [int(np.argmin(np.abs(fit.poles - pole))) for fit in usable]
        every = np.array([fit.poles[row] for fit, row in zip(usable, near, strict=True)])
        middle = complex(np.median(every.real), np.median(every.imag))
        first = int(np.argmin(np.abs(every - middle)))
        poles_again.append(middle)
        shapes.append(usable[first].shapes[near[first]])
    return np.array(poles_again, dtype=np.complex128), np.array(shapes, dtype=np.complex128)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _FoundModes:
    """Modes: poles [rad/s], shapes, errors of ln damping and ln frequency, and chance."""

    poles: ComplexArray
    shapes: ComplexArray
    errors: FloatArray
    chance: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Subspace:
    """Left singular vectors of the block Hankel matrix, scaled."""

    vectors: FloatArray
    n_responses: int
    interval: float


def identify_output_only(
    responses: FloatArray, sample_rate: float, settings: Settings
) -> ModeSet:
    """Return the modes of a record whose input was not measured, taken for broadband.

    Parameters
    ----------
    responses : (n_responses, n_samples) array
        Responses [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    settings : Settings
        Band, number of modes, highest order, poles to keep.

    Returns
    -------
    ModeSet
        Without a model; intervals from leaving out one of twelve blocks of the record at a
        time (jackknife). Shapes have no scale, and an imaginary part only as far
        as it stands out of its scatter; a tone of the excitation looks like a mode of hardly
        any damping.

    Raises
    ------
    ValueError
        If the record is too short for the band.

    References
    ----------
    .. [1] B. Peeters and G. De Roeck, "Reference-based stochastic subspace identification for
       output-only modal analysis", Mechanical Systems and Signal Processing 13, 855-878, 1999.
    """
    samples, interval, scale = _slower(responses, sample_rate, settings.band[1])
    n = samples.shape[0]
    n_rows = int(np.clip(2.0 / (settings.band[0] * interval), settings.order / n + 2, ROWS / n))
    if samples.shape[1] < 4 * BLOCKS * n_rows:
        raise ValueError(
            f"{numeral(samples.shape[1] * interval, 4)} s are too short for output only from "
            f"{settings.band[0]:g} Hz: at least "
            f"{numeral(4 * BLOCKS * n_rows * interval)} s are needed"
        )
    parts = _correlations(samples, 2 * n_rows)
    diagram, modes, notes = _modes(parts, n_rows, interval, scale, settings)
    poles = modes.poles
    tones = [
        f"{numeral(value, 4)} Hz has hardly any damping: a tone of the excitation looks like "
        "that"
        for value in frequency_of(poles[damping_of(poles) < TONE_DAMPING])
    ]
    student = scipy.special.stdtrit(BLOCKS - 1, 0.975) / NORMAL_95  # over the normal law
    return ModeSet(
        method="output only",
        poles=poles,
        damping_error=student * modes.errors[0],
        frequency_error=student * modes.errors[1],
        shapes=normalised(without_chance(modes.shapes, modes.chance)),
        participation=np.ones((poles.size, 0), dtype=np.complex128),
        diagram=diagram,
        model=None,
        interval_from=f"scatter over {BLOCKS} blocks of the record (jackknife)",
        notes=(
            "output only: the input is taken for broadband, shapes have no scale",
            *tones,
            *notes,
        ),
    )


def _modes(
    parts: FloatArray, n_rows: int, interval: float, scale: FloatArray, settings: Settings
) -> tuple[Diagram, _FoundModes, list[str]]:
    """Return the diagram, the modes that were selected, and the unmet wishes."""
    n = parts.shape[-1]
    whole = _subspace(parts.sum(axis=0), n_rows, interval)
    highest = min(settings.order, (n_rows - 1) * n)
    orders = [order for order in orders_of(settings) if order <= highest]
    diagram = diagram_of([_poles(whole, order) for order in orders], settings.band, TOLERANCES)
    poles, shapes, wanted, notes = _chosen(diagram, len(orders), settings)
    by_frequency = np.argsort(np.abs(poles), kind="stable")
    poles, shapes, wanted = poles[by_frequency], shapes[by_frequency], wanted[by_frequency]
    shapes = normalised(shapes * scale)
    spaces = [
        _subspace(parts.sum(axis=0) - part, n_rows, interval)
        for part in (parts if poles.size else ())
    ]
    others = [[_poles(space, order) for order in orders] for space in spaces]
    errors, chance = jackknife(others, diagram, poles, shapes, scale)
    known = wanted | (errors[0] < UNKNOWN_DAMPING)
    modes = _FoundModes(poles[known], shapes[known], errors[:, known], chance[known])
    if settings.modes is not None and modes.poles.size < settings.modes:
        notes.append(
            f"{settings.modes} modes were asked for, the measurement shows {modes.poles.size}"
        )
    return diagram, modes, notes


def _chosen(
    diagram: Diagram, n_orders: int, settings: Settings
) -> tuple[ComplexArray, ComplexArray, NDArray[np.bool_], list[str]]:
    """Return poles, shapes, which of them the user wants kept, and which are missing."""
    poles, shapes, counts = candidates(diagram)
    real = counts >= max(3, n_orders // KEPT_ORDERS)
    real &= damping_of(poles) < MOST_DAMPING
    if shapes.shape[1] > 1:
        real &= phase_collinearity(shapes) > LEAST_COLLINEARITY
    poles, shapes, counts = poles[real], shapes[real], counts[real]
    rows, notes = requested_poles(diagram, poles, settings.keep)
    wanted = are_requested(poles, settings.keep)
    if settings.modes is not None:
        room = max(settings.modes - rows.size, int(wanted.sum()))
        first = np.lexsort((-counts, ~wanted))[:room]
        poles, shapes, wanted = poles[first], shapes[first], wanted[first]
    return (
        np.concatenate([poles, diagram.poles[rows]]),
        np.concatenate([shapes, diagram.shapes[rows]]),
        np.concatenate([wanted, np.ones(rows.size, dtype=bool)]),
        notes,
    )


def _slower(
    responses: FloatArray, sample_rate: float, highest: float
) -> tuple[FloatArray, float, FloatArray]:
    """Return samples that end above the highest frequency, their interval [s], their scale."""
    centred = responses - responses.mean(axis=1, keepdims=True)
    n = centred.shape[1]
    wanted = min(n, int(np.ceil(2.0 * HIGHEST_OVER_BAND * highest * n / sample_rate)))
    spectrum = scipy.fft.rfft(centred)[:, : wanted // 2 + 1]
    slower = scipy.fft.irfft(spectrum, wanted)
    scale = np.std(slower, axis=1)
    scale = np.where(scale > 0.0, scale, 1.0)
    return slower / scale[:, np.newaxis], n / sample_rate / wanted, scale


def _correlations(samples: FloatArray, n_lags: int) -> FloatArray:
    """Return sums of y(t + k) y(t)^T over the t of each block, (blocks, lags, n, n)."""
    n, length = samples.shape
    size = (length - n_lags) // BLOCKS
    values = np.empty((BLOCKS, n_lags, n, n))
    for block in range(BLOCKS):
        start = block * size
        now = samples[:, start : start + size]
        later = samples[:, start : start + size + n_lags]
        padded = scipy.fft.next_fast_len(size + 2 * n_lags, real=True)
        first, second = scipy.fft.rfft(now, padded), scipy.fft.rfft(later, padded)
        product = second[:, np.newaxis] * first.conj()[np.newaxis]
        values[block] = np.moveaxis(scipy.fft.irfft(product, padded)[..., :n_lags], -1, 0)
    return values


def _subspace(correlation: FloatArray, n_rows: int, interval: float) -> _Subspace:
    n = correlation.shape[1]
    index = np.arange(n_rows)
    blocks = correlation[1 + index[:, np.newaxis] + index[np.newaxis]]
    hankel = blocks.transpose(0, 2, 1, 3).reshape(n_rows * n, n_rows * n)
    # balanced: the vectors times roots of the singular values are the observability matrix
    vectors, sizes, _ = scipy.linalg.svd(hankel, check_finite=False)
    return _Subspace(vectors * np.sqrt(sizes), n, interval)


def _poles(space: _Subspace, order: int) -> OrderPoles:
    """Return poles and shapes of one order."""
    observed = space.vectors[:, :order]
    above, below = observed[: -space.n_responses], observed[space.n_responses :]
    step = np.linalg.lstsq(above, below, rcond=None)[0]
    values, vectors = np.linalg.eig(step)
    poles = np.asarray(np.log(values + 0j) / space.interval, dtype=np.complex128)
    kept = np.flatnonzero(
        (poles.imag > 0.0) & (poles.imag < 0.999 * np.pi / space.interval) & (poles.real < 0.0)
    )
    kept = kept[np.argsort(poles.imag[kept])]
    shapes: ComplexArray = (observed[: space.n_responses] @ vectors[:, kept]).T
    return OrderPoles(order, poles[kept], unit_shapes(shapes))
