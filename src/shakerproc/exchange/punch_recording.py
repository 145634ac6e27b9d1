"""A punch file as a recording: one channel for each component that moves."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.data import Channel, FloatArray, Recording, recording_of_arrays
from shakerproc.errors import ExchangeError
from shakerproc.exchange.nastran_decks import forces_of_deck
from shakerproc.exchange.nastran_punch import COMPONENTS, PunchTable, read_punch

STRAY: Final = 1e-3
"""How far a time may stray from its place, in steps: punch holds seven digits."""


def recording_of_punch(path: Path, deck: Path | None = None) -> Recording:
    """Return the results of a punch file as a recording in memory.

    Channels are called like ``node 2 acceleration x``. Components that are zero throughout,
    such as those of a node that is held, are left out and counted in a note. Units are those
    of a deck in SI, as `shakerproc nastran write` makes them; then displacements are relative
    to the base.

    Parameters
    ----------
    path : Path
        The punch file.
    deck : Path, optional
        The deck that made it; its forces over the masses they act on become channels called
        like ``control F/m node 2`` [m/s²], the controls of what follows. Where the base is
        shaken this is its acceleration with the sign turned.

    Raises
    ------
    ExchangeError
        If the file is damaged, runs over frequency, or its time steps are not equal.
    """
    tables = read_punch(path)
    if tables[0].abscissa != "time" or np.iscomplexobj(tables[0].values):
        raise ExchangeError(
            f"{path.name}: results over {tables[0].abscissa}, a recording runs over time; "
            f"punch a transient solution"
        )
    rate = _sample_rate(path, tables[0].at)
    channels, rows = [], []
    left_out = 0
    for table in tables:
        for point, values in zip(table.points, table.values, strict=True):
            for component, samples in zip(COMPONENTS, values, strict=True):
                if np.any(samples != 0.0):
                    channels.append(_channel(table, point, component))
                    rows.append(samples)
                else:
                    left_out += 1
    if not rows:
        raise ExchangeError(f"{path.name}: every result is zero; was a load applied?")
    for node, (time, force, mass) in (forces_of_deck(deck) if deck else {}).items():
        name, unit = f"control F/m node {node}", "m/s^2"
        channels.append(Channel(name=name, unit=unit, source_name=name, source_unit=unit))
        rows.append(np.interp(tables[0].at, time, force / mass))
    recording = recording_of_arrays(path.stem, channels, np.array(rows), rate)
    note = f"{left_out} components that are zero throughout are left out"
    return replace(recording, path=path, notes=(note,) if left_out else ())


def _channel(table: PunchTable, point: int, component: str) -> Channel:
    angular = component.startswith("about")
    unit = table.unit.replace("m", "rad", 1) if angular else table.unit
    name = f"node {point} {table.quantity} {component}"
    return Channel(name=name, unit=unit, source_name=name, source_unit=unit)


def _sample_rate(path: Path, times: FloatArray) -> float:
    """Return samples per second [Hz].

    Raises
    ------
    ExchangeError
        If the steps are not equal.
    """
    if times.size < 2:
        raise ExchangeError(f"{path.name}: {times.size} time steps, at least 2 are needed")
    step = (times[-1] - times[0]) / (times.size - 1)
    ideal = times[0] + step * np.arange(times.size)
    # printed with seven digits, late times are rounded more coarsely than early ones
    allowed = np.maximum(STRAY * step, 1e-6 * np.abs(times))
    wrong = np.flatnonzero(np.abs(times - ideal) > allowed)
    if wrong.size:
        place = float(times[wrong[0]])
        raise ExchangeError(
            f"{path.name}: the time steps are not equal (at {place:g} s); let Nastran write "
            f"equal steps with NLSTEP and FIXED"
        )
    return round_rate(1.0 / float(step))


def round_rate(rate: float) -> float:
    """Return a rate without the rounding of printed times: a whole number where it is near.

    `rate` is in [Hz].
    """
    near = float(round(rate))
    return near if near > 0.0 and abs(rate - near) < 1e-6 * rate else rate
