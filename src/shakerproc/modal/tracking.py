"""Modes tracked over several tests: matched by frequency and shape."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.modal_model import ModeSet
from shakerproc.modal.shapes import mac

MOST_SHIFT: Final = 0.2
"""Relative change of frequency beyond which two modes are never one [-]."""

LEAST_MAC: Final = 0.5
"""MAC below which two modes are never one [-]."""

NARROW_SHIFT: Final = 0.05
"""Relative change of frequency allowed where shapes cannot tell modes apart [-]."""

TELLING: Final = 3
"""Sensors in common from which on shapes tell modes apart."""


@final
@dataclass(frozen=True, slots=True)
class Sighting:
    """A mode of a track in one test.

    Attributes
    ----------
    test : int
        Number of the test, from 0.
    mode : int
        Number of the mode in it, from 0.
    mac : float, optional
        With the shape in the first test of the track, over the sensors in common [-]; None
        where there are fewer than two of these.
    """

    test: int
    mode: int
    mac: float | None


@final
@dataclass(frozen=True, slots=True)
class Track:
    """One mode through the tests.

    Attributes
    ----------
    sightings : tuple of Sighting
        By test.
    """

    sightings: tuple[Sighting, ...]


def tracks_of(sets: Sequence[ModeSet], sensors: Sequence[Sequence[str]]) -> tuple[Track, ...]:
    """Return the modes of several tests, each followed through them.

    Parameters
    ----------
    sets : sequence of ModeSet
        Modes of each test.
    sensors : sequence of sequence of str
        Names of the sensors of each test, in the order of the shapes.

    Returns
    -------
    tuple of Track
        By frequency where first seen.
    """
    tracks: list[list[Sighting]] = []
    for test, modes in enumerate(sets):
        taken = _matched(tracks, sets, sensors, test)
        for mode in range(modes.poles.size):
            if mode in taken:
                track, alike = taken[mode]
                tracks[track].append(Sighting(test, mode, alike))
            else:
                tracks.append([Sighting(test, mode, 1.0 if len(sensors[test]) > 1 else None)])
    tracks.sort(key=lambda track: sets[track[0].test].frequency[track[0].mode])
    return tuple(Track(tuple(track)) for track in tracks)


def _matched(
    tracks: Sequence[Sequence[Sighting]],
    sets: Sequence[ModeSet],
    sensors: Sequence[Sequence[str]],
    test: int,
) -> dict[int, tuple[int, float | None]]:
    """Return for modes of a test their track and the MAC with its first shape."""
    modes = sets[test]
    if not tracks or not modes.poles.size:
        return {}
    cost = np.full((len(tracks), modes.poles.size), 1e6)
    alike: dict[tuple[int, int], float | None] = {}
    for number, track in enumerate(tracks):
        first, last = track[0], track[-1]
        mine, theirs = common(sensors[first.test], sensors[test])
        shift = np.abs(np.log(modes.frequency / sets[last.test].frequency[last.mode]))
        values = None
        if len(mine) > 1:
            own = sets[first.test].shapes[first.mode][mine]
            values = mac(own[np.newaxis], modes.shapes[:, theirs])[0]
        for mode in range(modes.poles.size):
            alike[number, mode] = None if values is None else float(values[mode])
            cost[number, mode] = _cost(float(shift[mode]), alike[number, mode], len(mine))
    rows, columns = scipy.optimize.linear_sum_assignment(cost)
    return {
        int(mode): (int(number), alike[int(number), int(mode)])
        for number, mode in zip(rows, columns, strict=True)
        if cost[number, mode] < 1e5
    }


def _cost(shift: float, alike: float | None, n_common: int) -> float:
    """Return how unlike two modes are; more than 1e5 where they are never one."""
    if alike is None or n_common < TELLING:
        return shift if shift < NARROW_SHIFT else 1e6
    if shift > MOST_SHIFT or alike < LEAST_MAC:
        return 1e6
    return (1.0 - alike) + shift


def common(first: Sequence[str], second: Sequence[str]) -> tuple[list[int], list[int]]:
    """Return the places of the sensors that two tests share, in the one and in the other."""
    there = {name: i for i, name in enumerate(second)}
    mine = [i for i, name in enumerate(first) if name in there]
    return mine, [there[first[i]] for i in mine]


def mac_over(
    first: ComplexArray, second: ComplexArray, names: tuple[Sequence[str], Sequence[str]]
) -> FloatArray | None:
    """Return the MAC of shapes over the sensors in common; None where there is but one.

    Shapes may be in any unit.
    """
    mine, theirs = common(*names)
    if len(mine) < 2:
        return None
    return mac(first[:, mine], second[:, theirs])
