"""From the samples of inputs and responses to modes with their intervals and their scatter."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.likelihood import fit
from shakerproc.modal.lines import (
    Lines,
    joined,
    lines_of_functions,
    lines_of_samples,
    lines_subset,
    thinned,
    thinning_note,
)
from shakerproc.modal.modal_model import NORMAL_95, Method, ModalFit, ModeSet, Settings
from shakerproc.modal.selection import N_PARTS, confirmed, parts_of, price_of, selected
from shakerproc.modal.shapes import normalised
from shakerproc.modal.stabilisation import (
    Diagram,
    candidates,
    damping_of,
    frequency_of,
    lagged_sums,
    requested_poles,
    stabilisation,
)
from shakerproc.numerals import numeral

KEPT_ORDERS: Final = 4
"""A pole that stays over one in so many of the orders begins as a mode; others are tried."""

LOW_ORDERS: Final = 6
"""Poles of orders up to this are tried as well: noise hides what higher orders spread out."""

PART: Final = 2.5
"""Ratio of the ends of the parts that a wide band is cut into for more candidates [-]."""

PART_ORDER: Final = 40
"""Highest order in such a part."""


def identify_samples(
    inputs: FloatArray, responses: FloatArray, sample_rate: float, settings: Settings
) -> ModeSet:
    """Return the modes of a record with measured inputs, whatever the excitation.

    Candidates are the poles that stay over the orders of a least-squares complex frequency fit
    of the spectra; those that the measurement needs are refined by maximum likelihood.

    Parameters
    ----------
    inputs : (n_inputs, n_samples) array
        Forces or base motions [unit of the channel].
    responses : (n_responses, n_samples) array
        Responses [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    settings : Settings
        Band, number of modes, highest order.

    Returns
    -------
    ModeSet
        With 95 % intervals from the scatter of the lines about the model.

    Raises
    ------
    ValueError
        If the band holds too few lines for the order.
    """
    return identify_records([(inputs, responses)], sample_rate, settings)


def identify_records(
    records: Sequence[tuple[FloatArray, FloatArray]], sample_rate: float, settings: Settings
) -> ModeSet:
    """Return the modes that several records of one structure share, in one fit.

    Poles, residues and residual terms are common; each record has a transient of its own.

    Parameters
    ----------
    records : sequence of (array, array)
        Inputs, (n_inputs, n_samples), and responses, (n_responses, n_samples), of each; the
        same ones in the same order, 0 where an input does not act [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    settings : Settings
        Band, number of modes, highest order.

    Returns
    -------
    ModeSet
        With 95 % intervals from the scatter of the lines about the model, wider where the
        records, or the parts of one, scatter more; `scatter` is that over several records.

    Raises
    ------
    ValueError
        If the band holds too few lines for the order.
    """
    parts = [lines_of_samples(*record, sample_rate, settings.band) for record in records]
    lines = joined(parts)
    level = np.sqrt(np.mean(np.abs(lines.inputs) ** 2))
    driven = np.concatenate([lines.inputs, level * lines.records])
    outputs = lines.outputs[:, np.newaxis]
    diagram = _diagram(lines, driven, outputs, settings)
    more = _of_parts(lines, driven, outputs)
    # poles of one resonance that moves are told from modes where parts of the record differ
    own = parts_of(*records[0], sample_rate, settings.band) if len(records) == 1 else []
    mode_set = _modes(lines, diagram, more, settings, "input and response spectra", parts=own)
    if len(records) > 1:
        return with_scatter(mode_set, parts)
    if len(own) < N_PARTS[0]:  # two or four say little of scatter
        return mode_set
    return replace(with_scatter(mode_set, own, PARTS), scatter=None)


def identify_functions(
    frequency: FloatArray,
    functions: ComplexArray,
    settings: Settings,
) -> ModeSet:
    """Return the modes of response functions, such as those of an analyser.

    Their leakage cannot be taken out any more: a damping that the lines do not resolve comes
    out too large.

    Parameters
    ----------
    frequency : (n_lines,) array
        Evenly spaced [Hz].
    functions : (n_responses, n_inputs, n_lines) complex array
        Response functions [response unit/input unit].
    settings : Settings
        Band, number of modes, highest order.

    Returns
    -------
    ModeSet
        With 95 % intervals from the scatter of the lines about the model.

    Raises
    ------
    ValueError
        If the band holds too few lines for the order.
    """
    low, high = settings.band
    kept = (frequency >= low) & (frequency <= high) & (frequency > 0.0)
    lines = lines_of_functions(frequency[kept], functions[..., kept])
    ones = np.ones((1, lines.frequency.size), dtype=np.complex128)
    diagram = _diagram(lines, ones, functions[..., kept], settings)
    parts = _of_parts(lines, ones, functions[..., kept])
    modes = _modes(lines, diagram, parts, settings, "response functions")
    shapes, participation = split_residues(
        modes.model.residues.reshape(-1, *functions.shape[:2])  # type: ignore[union-attr]
    )
    return replace(modes, shapes=shapes, participation=participation)


def _diagram(
    lines: Lines, driven: ComplexArray, outputs: ComplexArray, settings: Settings
) -> Diagram:
    """Return the stabilisation diagram.

    Raises
    ------
    ValueError
        If there are too few lines for the order.
    """
    n_unknown = settings.order * (driven.shape[0] + outputs.shape[1])
    if lines.frequency.size < n_unknown:
        highest = lines.frequency.size // (driven.shape[0] + outputs.shape[1])
        raise ValueError(
            f"order {settings.order} is too high for {lines.frequency.size} lines: at most "
            f"{highest}"
        )
    sums = lagged_sums(lines.frequency, driven, outputs, settings.order)
    return stabilisation(sums, orders_of(settings), settings.band)


def orders_of(settings: Settings) -> range:
    """Return the orders of the diagram, two poles for each mode."""
    return range(2, settings.order + 1, 2)


def _of_parts(lines: Lines, driven: ComplexArray, outputs: ComplexArray) -> ComplexArray:
    """Return poles of clusters in parts of a wide band, where one fit sees the loudest only."""
    low, high = float(lines.frequency[0]), float(lines.frequency[-1])
    n_parts = int(np.log(high / low) / np.log(PART))
    if n_parts < 2:
        return np.zeros(0, dtype=np.complex128)
    ratio = (high / low) ** (1.0 / n_parts)
    part_poles = []
    for part in range(n_parts):
        begin, end = low * ratio**part, low * ratio ** (part + 1)
        kept = (lines.frequency >= 0.9 * begin) & (lines.frequency <= 1.1 * end)
        order = min(PART_ORDER, int(kept.sum()) // (driven.shape[0] + outputs.shape[1]))
        if order < 8:
            continue
        frequency = lines.frequency[kept]
        sums = lagged_sums(frequency, driven[:, kept], outputs[..., kept], order)
        diagram = stabilisation(sums, range(2, order + 1, 2), (begin, end))
        part_poles.append(candidates(diagram)[0])
    return np.concatenate([np.zeros(0, dtype=np.complex128), *part_poles])


def _modes(
    lines: Lines, diagram: Diagram, more: ComplexArray, settings: Settings, method: Method,
    *, parts: Sequence[Lines] = (),
) -> ModeSet:  # fmt: skip
    thin = thinned(lines)
    poles, _, counts = candidates(diagram)
    by_count = np.argsort(-counts)
    certain = counts[by_count] >= max(3, len(orders_of(settings)) // KEPT_ORDERS)
    ordered = poles[by_count]
    notes = [] if thin is lines else [thinning_note(lines, thin)]
    low = diagram.poles[diagram.order <= LOW_ORDERS]
    doubtful = np.concatenate([ordered[~certain], more, low])
    thin, model = selected(thin, ordered[certain], doubtful, settings.band)
    model = confirmed(thin, model, parts)
    model, told = with_requested_modes(thin, model, diagram, settings)
    shapes, participation = split_residues(model.residues)
    errors = np.sqrt(np.diag(model.covariance)).reshape(-1, 2)
    return ModeSet(
        method=method,
        poles=model.poles,
        damping_error=errors[:, 0],
        frequency_error=errors[:, 1],
        shapes=shapes,
        participation=participation,
        diagram=diagram,
        model=model,
        interval_from="scatter of the lines about the model",
        notes=(*notes, *told),
    )


def with_requested_modes(
    lines: Lines, model: ModalFit, diagram: Diagram, settings: Settings
) -> tuple[ModalFit, list[str]]:
    """Return the model with the number of modes and the poles that the user wants.

    Returns
    -------
    model : ModalFit
        Refitted where something was to be changed.
    notes : list of str
        What could not be done.
    """
    rows, notes = requested_poles(diagram, model.poles, settings.keep)
    poles = np.append(model.poles, diagram.poles[rows])
    if poles.size > model.poles.size:
        model = fit(lines, poles)
    while settings.modes is not None and model.poles.size > settings.modes:
        model = fit(lines, np.delete(model.poles, int(np.argmin(model.losses))))
    if settings.modes is not None and model.poles.size < settings.modes:
        notes.append(
            f"{settings.modes} modes were asked for, the measurement shows {model.poles.size}"
        )
    return model, notes


def split_residues(residues: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return shapes and participations of residues, which are their products.

    Parameters
    ----------
    residues : (n_modes, n_responses, n_inputs) complex array
        Residues [unit of the functions, rad/s].

    Returns
    -------
    shapes : (n_modes, n_responses) complex array
        Turned to their mean phase, largest component 1 [-].
    participation : (n_modes, n_inputs) complex array
        Largest component 1 [-].
    """
    if not residues.size:
        return residues[:, :, 0], residues[:, 0]
    left, _, right = np.linalg.svd(residues, full_matrices=False)
    return normalised(left[..., 0]), normalised(right[:, 0])


MUCH: Final = 2.0
"""Ratio of the scatter over records to what their own intervals allow, from which on a mode is
said to change from record to record [-]."""

MOST_LINES: Final = 4_000
"""Lines of a record that its own poles are refined on."""


TESTS: Final = (
    "tests",
    "the structure is not the same in all of them, or not linear; analyse them apart",
)
"""What the records of one fit are, and what it means that a mode scatters over them."""

BLOWS: Final = ("blows", TESTS[1])
"""The same of the blows of one test."""

PARTS: Final = (
    "parts of the record",
    "it moves with level or time: the structure is not linear, or changes",
)
"""The same of the parts of one record."""


def with_scatter(
    modes: ModeSet, records: Sequence[Lines], kind: tuple[str, str] = TESTS
) -> ModeSet:
    """Return the modes with their scatter over the records, and intervals that allow for it.

    Each record is fitted alone, from the common poles. Where they scatter more than their own
    intervals allow, the interval of the common mode is widened by that ratio (`widening`).

    Parameters
    ----------
    modes : ModeSet
        Of all records together.
    records : sequence of Lines
        What it was found from, each alone.
    kind : (str, str)
        What the records are, and what it means that a mode scatters over them, in words.

    References
    ----------
    .. [1] R. T. Birge, "The calculation of errors by the method of least squares", Physical
       Review 40, 207-227, 1932.
    """
    if not modes.poles.size:
        return modes
    named, meaning = kind
    values, errors = _alone(modes, records)
    ratio, wider = widening(values, errors)
    scatter = _deviation(values)
    moving = [
        f"mode {i + 1} ({modes.frequency[i]:.5g} Hz) scatters over the {named} by "
        f"{numeral(100.0 * scatter[0, i], 2)} % in frequency and "
        f"{numeral(100.0 * scatter[1, i], 2)} % in damping, {numeral(ratio[:, i].max(), 2)} "
        f"times what their intervals allow: {meaning}"
        for i in range(modes.poles.size)
        if ratio[:, i].max() > MUCH
    ]
    return replace(
        modes,
        frequency_error=modes.frequency_error * wider[0],
        damping_error=modes.damping_error * wider[1],
        scatter=scatter,
        interval_from=f"{modes.interval_from}, wider where the {named} scatter more",
        notes=(*modes.notes, *moving),
    )


def widening(values: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return by how much values scatter more than their errors say, and intervals are widened.

    Of few records the ratio is uncertain itself: an interval that rests on it is one of
    Student's t.

    Parameters
    ----------
    values : (n_records, ...) array
        What each record says; NaN where one says nothing.
    errors : (n_records, ...) array
        Their standard deviations, by each record alone.

    Returns
    -------
    ratio : (...) array
        Birge's [-].
    wider : (...) array
        Factor of the errors, 1.96 of which are the 95 % interval [-]; 1 or more.
    """
    weight = np.where(np.isnan(values), 0.0, 1.0 / errors**2)
    filled = np.nan_to_num(values)
    free = np.maximum((weight > 0.0).sum(axis=0) - 1, 1)
    total = np.maximum(weight.sum(axis=0), 1e-300)
    mean = (weight * filled).sum(axis=0) / total
    ratio = np.sqrt((weight * (filled - mean) ** 2).sum(axis=0) / free)
    # few records know their scatter badly: Student's t in place of the normal
    student = scipy.special.stdtrit(free, 0.975) / NORMAL_95
    return ratio, np.where(ratio > 1.0, ratio * student, 1.0)


def _deviation(values: FloatArray) -> FloatArray:
    """Return standard deviations over records, NaN where fewer than two show the mode."""
    seen = ~np.isnan(values)
    count = seen.sum(axis=0)
    mean = np.nansum(values, axis=0) / np.maximum(count, 1)
    square = np.nansum((values - mean) ** 2, axis=0) / np.maximum(count - 1, 1)
    return np.asarray(np.where(count > 1, np.sqrt(square), np.nan))


def _alone(modes: ModeSet, records: Sequence[Lines]) -> tuple[FloatArray, FloatArray]:
    """Return ln(frequency) and ln(damping) from each record alone, and their errors.

    Both are (n_records, 2, n_modes), NaN where a record does not show the mode, as of a force
    at its node.
    """
    values = np.full((len(records), 2, modes.poles.size), np.nan)
    errors = np.ones_like(values)
    for number, record in enumerate(records):
        acting = np.abs(record.inputs).max(axis=1) > 0.0
        subset = lines_subset(
            record, slice(None, None, -(-record.frequency.size // MOST_LINES))
        )
        subset = replace(subset, inputs=subset.inputs[acting])
        seen = np.flatnonzero(fit(subset, modes.poles, 0).losses > price_of(subset))
        alone = fit(subset, modes.poles[seen])
        if not seen.size:
            continue
        spread = np.sqrt(np.diag(alone.covariance)).reshape(-1, 2)
        near = np.argmin(np.abs(np.subtract.outer(modes.poles[seen], alone.poles)), axis=1)
        alone_values = frequency_of(alone.poles[near]), damping_of(alone.poles[near])
        values[number][:, seen] = np.log(np.stack(alone_values))
        errors[number][:, seen] = np.maximum(spread[near][:, ::-1].T, 1e-12)
    return values, errors


def scatter_text(modes: ModeSet, mode: int) -> list[str]:
    """Return the scatter of a mode over tests of one fit in %: of frequency, and of damping."""
    if modes.scatter is None:
        return []
    return [
        "one test" if np.isnan(value) else numeral(100.0 * value, 2)
        for value in modes.scatter[:, mode]
    ]
