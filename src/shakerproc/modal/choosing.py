"""Which channels of a test are inputs and responses, which band, and what is in the way."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from shakerproc.data import Channel, Recording
from shakerproc.errors import SpectrumError
from shakerproc.geometry import Place, Wireframe
from shakerproc.modal.mode_set import ModeSet
from shakerproc.modal.shapes import mac
from shakerproc.numerals import numeral
from shakerproc.runs.roles import NEAR
from shakerproc.testlog import Modal, Test

SINGLE_FREQUENCIES: Final = ("sine", "stepped sine")
"""Kinds of excitation that tell no modes."""

MUCH_LEFT: Final = 0.3
"""Share of a response that modes leave, from which on it is said [-]."""

ONE_SHAPE: Final = 0.99
"""MAC from which on two shapes are one, as those of one mode in two tests are [-]."""

DEFAULT_BAND: Final = (20.0, 0.42)
"""Band where nobody says one: from so many lines to so much of the sample rate."""


def band_of(recording: Recording, test: Test, wish: Modal) -> tuple[float, float]:
    """Return where modes are looked for [Hz].

    Raises
    ------
    SpectrumError
        If the recording does not reach there.
    """
    nyquist = recording.sample_rate / 2.0
    duration = recording.n_samples / recording.sample_rate
    usual = (DEFAULT_BAND[0] / duration, DEFAULT_BAND[1] * recording.sample_rate)
    said = wish.band or test.processing.band or test.band
    low, high = usual if said is None else said
    if wish.band is not None and high > nyquist:
        raise SpectrumError(
            f"{recording.run}: the band from {low:g} to {high:g} Hz lies outside the data, "
            f"which reach to {nyquist:g} Hz; correct band under modal"
        )
    high = min(high, 0.49 * recording.sample_rate)
    low = max(low, 2.0 / duration)
    if not low < high:
        raise SpectrumError(
            f"{recording.run}: the band from {low:g} to {high:g} Hz is empty; the recording "
            f"holds {numeral(2.0 / duration)} to {nyquist:g} Hz"
        )
    return low, high


def inputs_of(recording: Recording, wish: Modal) -> list[tuple[str, tuple[int, ...]]]:
    """Return name and rows of each input: the mean of the controls, or each force.

    Raises
    ------
    SpectrumError
        If there are none of those that the log wants.
    """
    roles = [channel.role for channel in recording.channels]
    controls = tuple(i for i, role in enumerate(roles) if role == "control")
    forces = tuple(i for i, role in enumerate(roles) if role == "force")
    wanted = wish.inputs or ("control" if controls else "force" if forces else "none")
    if wanted == "none":
        return []
    rows = controls if wanted == "control" else forces
    if not rows:
        raise SpectrumError(
            f"{recording.run}: no channel has the role {wanted}, which modal: {{inputs: "
            f"{wanted}}} asks for; give it to the channel that measures the input"
        )
    if wanted == "control":
        name = " and ".join(recording.channels[i].name for i in rows)
        return [(f"mean of {name}" if len(rows) > 1 else name, rows)]
    return [(recording.channels[i].name, (i,)) for i in rows]


def responses_of(recording: Recording, taken: set[int]) -> list[int]:
    """Return the rows of the responses.

    Raises
    ------
    SpectrumError
        If there are none.
    """
    kinds = {"response", "displacement", "velocity"} | (set() if taken else {"control"})
    rows = [i for i, c in enumerate(recording.channels) if c.role in kinds and i not in taken]
    if not rows:
        raise SpectrumError(
            f"{recording.run}: no channel has the role response; a mode needs at least one"
        )
    return rows


def remarks_of(
    sensors: Sequence[Channel],
    positions: Sequence[Place | None],
    modes: ModeSet,
    *,
    incomplete: bool,
    places: str = "add position: [0 mm, 0 mm, 0 mm] and direction: z to the channels",
    wireframe: Wireframe | None = None,
) -> list[str]:
    """Return the obstacles to more modes, a sentence each; `places` is how to say positions."""
    found = []
    if incomplete:
        found.append("the recording was cut short: its complete part was used")
    if len(sensors) == 1:
        found.append(
            "one response only: modes have no shape, and modes that are close are told apart "
            "by frequency alone; MAC needs two sensors or more"
        )
    without = [
        sensor.name
        for sensor, position in zip(sensors, positions, strict=True)
        if position is None
    ]
    if without and len(sensors) > 1:
        named = ", ".join(without[:6]) + (" and more" if len(without) > 6 else "")
        found.append(
            f"no position for {named}: shapes are drawn over the sensors' order; {places}"
        )
    elif wireframe is not None and len(sensors) > 1:
        found += _unmeasured(sensors, positions, wireframe)
    found += [
        f"modes at {first:.5g} and {second:.5g} Hz have one shape and lie within their widths: "
        "a resonance that a nonlinearity bends looks like two; compare levels, or say how many "
        f"there are (modal: {{modes: {modes.poles.size - 1}}})"
        for first, second in twins_of(modes)
    ]
    if modes.model is not None and modes.poles.size:
        left = float(np.max(modes.model.unexplained))
        if left > MUCH_LEFT:
            found.append(
                f"residual rms of up to {left:.0%} of a response: noise, a "
                "nonlinearity or an input that was not measured; look at the coherence"
            )
    if not modes.poles.size:
        found.append(
            "no pole stays over the orders: no mode found; look at the coherence, widen the "
            "band, take a longer record, or name poles under modal: {keep: [...]}"
        )
    return found


def _unmeasured(
    sensors: Sequence[Channel], positions: Sequence[Place | None], wireframe: Wireframe
) -> list[str]:
    """Return the parts of a geometry that no sensor moves, and sensors beside it."""
    told = [f"geometry: {note}" for note in wireframe.notes]
    if not wireframe.edges:
        return told
    where = np.array([wireframe.nodes[node] for node in wireframe.used])
    seats = np.array(positions, float)
    apart = np.linalg.norm(where[:, np.newaxis] - seats, axis=-1) > NEAR
    alone = [s.name for s, lost in zip(sensors, apart.all(axis=0), strict=True) if lost]
    if alone:
        told.append(
            f"geometry: {', '.join(alone[:6])} sit at no node of it: drawn without lines"
        )
    if still := int(apart.all(axis=1).sum()):
        told.append(
            f"geometry: {still} of {len(where)} nodes have no sensor: lines to them are drawn "
            f"at rest"
        )
    return told


def twins_of(modes: ModeSet) -> list[tuple[float, float]]:
    """Return pairs of frequencies [Hz] of modes that sensors cannot tell from one.

    Parameters
    ----------
    modes : ModeSet
        Modes; those of a single sensor have no shape that could tell.

    Returns
    -------
    list of (float, float)
        Neighbours whose shapes are alike and that lie closer than the wider one's half-power
        width.
    """
    if modes.shapes.shape[1] < 2:
        return []
    alike = mac(modes.shapes, modes.shapes) > ONE_SHAPE
    widths = 2.0 * modes.damping * modes.frequency
    return [
        (float(modes.frequency[i]), float(modes.frequency[i + 1]))
        for i in range(modes.poles.size - 1)
        if alike[i, i + 1]
        and modes.frequency[i + 1] - modes.frequency[i] < max(widths[i], widths[i + 1])
    ]
