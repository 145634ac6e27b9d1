"""Models in files of other programs: modes as structures, and elements of a Nastran deck."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError
from shakerproc.exchange.modes import ModeTable
from shakerproc.exchange.nastran_decks import Bush, TransientDeck
from shakerproc.geometry import Place
from shakerproc.models import BASE, AbstractMemorylessEffect, Element, Model
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.damper import Damper
from shakerproc.models.structure import (
    Structure,
    StructureMode,
    base_participations,
    seen_rigid_modes,
)


def seen_at(table: ModeTable, points: Mapping[str, str], axes: Collection[str]) -> ModeTable:
    """Return modes at some of their places alone.

    How the base moves them along `axes` is told by all places of the table, of which the points
    of a model are few: two tell no motion without a tilt from one with it.

    Parameters
    ----------
    table : ModeTable
        Modes at many places.
    points : mapping of str to str
        Names of the points, and the place of the table where each stands.
    axes : collection of str
        Directions in which the base may move.

    Returns
    -------
    ModeTable
        With the points as places, in the units of the table.
    """
    row_of = table.row_of
    participations = {axis: participations_of(table, axis) for axis in axes}
    return replace(
        table,
        places=tuple(points),
        shapes=table.shapes[[row_of[place] for place in points.values()]],
        participations={
            axis: share for axis, share in participations.items() if share is not None
        },
        positions={
            point: table.positions[place]
            for point, place in points.items()
            if place in table.positions
        },
    )


def participations_of(table: ModeTable, axis: str) -> FloatArray | None:
    """Return the participations along a direction of the base; None where nothing says them.

    As the table states them, else by all of its places [root of its unit of mass].
    """
    stated = table.participations.get(axis, table.participations.get(""))
    wanted = np.array([float(place.endswith(f"/{axis}")) for place in table.places])
    if stated is not None or not axis or not wanted.any():
        return stated
    return base_participations(table.shapes, table.frequencies == 0.0, wanted)


def modes_of(
    table: ModeTable, damping: FloatArray, axis: str
) -> tuple[tuple[StructureMode, ...], FloatArray | None]:
    """Return the modes of a structure that is seen at all places of a table.

    Parameters
    ----------
    table : ModeTable
        For a unit mass of a kilogram.
    damping : (n_modes,) array
        Damping ratios [-].
    axis : str
        Direction in which the base moves; empty where there is one alone.

    Returns
    -------
    modes : tuple of StructureMode
        Rigid-body modes are mixed anew; what moves no place is no mode of the structure.
    participations : (n_modes,) array, optional
        Of all modes of the table, as far as it tells them [sqrt(kg)].
    """
    turn = seen_rigid_modes(table.shapes, table.frequencies == 0.0)
    shapes = (table.shapes @ turn).T
    shares = participations_of(table, axis)
    turned = None if shares is None else shares @ turn
    modes = tuple(
        StructureMode(
            float(table.frequencies[i]),
            float(damping[i]) if table.frequencies[i] else 0.0,
            tuple(shape),
            None if turned is None else float(turned[i]),
        )
        for i, shape in enumerate(shapes)
        if np.any(shape)
    )
    return modes, shares


def structure_of(
    table: ModeTable, damping: FloatArray, direction: str | None = None
) -> Structure:
    """Return a table in SI units as a structure.

    Parameters
    ----------
    table : ModeTable
        In SI.
    damping : (n_modes,) array
        Damping ratios [-].
    direction : str, optional
        In which the base moves; by default the one in which all places are seen.
    """
    axes = [*(table.axes - {""} or table.participations)]
    axis = direction or (axes[0] if len(axes) == 1 else "")
    modes, _ = modes_of(table, damping, axis)
    seen = any(place.endswith(f"/{axis}") for place in table.places)
    return Structure(table.places, modes, axis if seen else None, {}, table.positions)


def table_of(structure: Structure) -> ModeTable:
    """Return a structure as a table of modes; without its residual flexibilities."""
    modes = structure.modes
    stated = [mode.participation for mode in modes]
    shares = np.array([value or 0.0 for value in stated])
    axis = structure.direction or ""
    where: dict[str, Place | None] = {p: structure.position_of(p) for p in structure.points}
    return ModeTable(
        structure.points,
        np.array([mode.frequency for mode in modes]),
        np.array([mode.shape for mode in modes]).T,
        np.array([mode.damping_ratio for mode in modes]),
        {axis: shares} if any(value is not None for value in stated) else {},
        {point: place for point, place in where.items() if place is not None},
        "SI",
    )


POINTS: Final = 2001
"""Of the table of a curved law over its range."""

WEAKEST: Final = 1e-3
"""Nominal stiffness of a spring with play, over its steepest: PBUSH may not be 0."""

_SPEEDS: Final = (-1.0, -1e-3, 1e-3, 1.0)  # to try whether a force depends on velocity [m/s]


@final
@dataclass(frozen=True, slots=True)
class _Law:
    """A force law with the sign of its joint."""

    effect: AbstractMemorylessEffect
    sign: float

    def force(self, z: FloatArray) -> FloatArray:
        return self.sign * self.effect.force_at(self.sign * z, np.zeros_like(z))

    def slope(self, z: float) -> float:
        return float(self.effect.slopes(np.array([self.sign * z]), np.zeros(1))[0][0])

    def switches(self) -> list[float]:
        return [self.sign * s.at for s in self.effect.switches()]


def deck_of_model(
    model: Model,
    time: FloatArray,
    excitation: FloatArray,
    *,
    initial_velocity: Mapping[str, float] | None = None,
    reach: float | None = None,
    steps: int | None = None,
) -> TransientDeck:
    """Return a model under an excitation as the contents of a SOL 400 deck.

    Displacements of the deck are relative to the base: a base that accelerates comes in as
    forces -m a. Laws of straight lines become tables that hold them exactly; curved ones are
    tables of 2001 points over ± `reach`, beyond which Nastran goes on in a straight line.

    Parameters
    ----------
    model : Model
        What is shaken.
    time, excitation : (n,) array
        Time [s], and acceleration of the base [m/s²] or force [N].
    initial_velocity : mapping of str to float, optional
        Of masses, relative to the base [m/s].
    reach : float, optional
        Largest relative displacement of the tables of curved laws [m].
    steps : int, optional
        Steps of output; by default those of `time`.

    Raises
    ------
    ModelError
        If the model has an effect that no such deck holds, or a curved law and no `reach`.
    """
    if model.structures:
        raise ModelError(
            f"{model.title}: no deck is written of structures by their modes; the program they "
            f"come from has them as elements."
        )
    masses = dict(model.masses)
    springs: dict[tuple[str, str], list[_Law]] = {}
    dampers: list[tuple[str, str, float]] = []
    extra: list[Bush] = []
    for number, element in enumerate(resolved(model)):
        first, second = element.between
        effect = element.effect
        if isinstance(effect, Damper):
            dampers.append((first, second, effect.damping or 0.0))
        elif isinstance(effect, AttachedMode):
            name = f"attached to {second} ({number + 1})"
            masses[name] = effect.mass
            extra.append(Bush((second, name), effect.stiffness))
            dampers.append((second, name, effect.damping))
        else:
            law = _Law(_static(number, element), 1.0)
            if (second, first) in springs:
                springs[second, first].append(replace(law, sign=-1.0))
            else:
                springs.setdefault((first, second), []).append(law)
    return TransientDeck(
        title=model.title,
        masses=masses,
        springs=[*(_bush(places, laws, reach) for places, laws in springs.items()), *extra],
        dampers=dampers,
        time=time,
        forces=_forces(model, masses, excitation),
        initial_velocity=dict(initial_velocity or {}),
        steps=time.size - 1 if steps is None else steps,
    )


def _forces(
    model: Model, masses: Mapping[str, float], excitation: FloatArray
) -> dict[str, FloatArray]:
    if model.excitation.on is not None:
        return {model.excitation.on: excitation}
    return {name: -mass * excitation for name, mass in masses.items()}


def _static(number: int, element: Element) -> AbstractMemorylessEffect:
    """Return the effect, if its force depends on the displacement alone.

    Raises
    ------
    ModelError
        If it does not.
    """
    effect = element.effect
    if isinstance(effect, AbstractMemorylessEffect):
        z = np.linspace(-1e-3, 1e-3, 41)
        still = effect.force_at(z, np.zeros_like(z))
        if all(np.array_equal(effect.force_at(z, z * 0.0 + v), still) for v in _SPEEDS):
            return effect
        why = "its force depends on velocity"
    else:
        why = "its force depends on what was before"
    raise ModelError(
        f"elements.{number + 1}: {effect.kind} between {' and '.join(element.between)}: {why}, "
        f"and the tables of a SOL 400 deck hold force over displacement only; leave it out, or "
        f"use shakerproc simulate"
    )


def _bush(places: tuple[str, str], laws: Sequence[_Law], reach: float | None) -> Bush:
    """Return the springs between two places as one.

    Raises
    ------
    ModelError
        If a law is curved and there is no `reach`.
    """
    switches = np.unique([s for law in laws for s in law.switches()])
    largest = float(np.max(np.abs(switches), initial=0.0))
    ends = np.unique([-2.0 * largest or -1e-3, *switches, 2.0 * largest or 1e-3])
    curved = [law for law in laws if not _straight(law, ends)]
    rest = sum(law.slope(0.0) for law in laws)
    if not curved and switches.size == 0:
        return Bush(places, rest)
    if curved:
        if reach is None:
            raise ModelError(
                f"{curved[0].effect.kind} between {' and '.join(places)}: its table needs a "
                f"range; give --reach, such as 1 mm"
            )
        reach = max(reach, 2.0 * largest)
        ends = np.unique([*ends, *np.linspace(-reach, reach, POINTS)])
    z, force = _table(laws, ends, switches)
    steps = np.diff(z) > 0.0
    steepest = float(np.max(np.abs(np.diff(force)[steps] / np.diff(z)[steps])))
    return Bush(places, rest if rest > 0.0 else WEAKEST * steepest, z, force)


def _straight(law: _Law, ends: FloatArray) -> bool:
    """Return whether a law is a straight line between every two of these places."""
    for low, high in pairwise(ends):
        z = low + (high - low) * np.array([1e-6, 0.3, 0.6, 1.0 - 1e-6])
        force = law.force(z)
        line = force[0] + (force[-1] - force[0]) * (z - z[0]) / (z[-1] - z[0])
        scale = float(np.max(np.abs(law.force(ends)))) or 1.0
        if np.max(np.abs(force - line)) > 1e-9 * scale:
            return False
    return True


def _table(
    laws: Sequence[_Law], places: FloatArray, switches: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return displacement and force; where the force jumps, the displacement stands twice."""
    tiny = 1e-9 * float(np.max(np.abs(places)))
    scale = max(abs(_total(laws, float(z))) for z in places)
    rows: list[tuple[float, float]] = []
    for z in map(float, places):
        before, after = _total(laws, z - tiny), _total(laws, z + tiny)
        if z in switches and abs(after - before) > 1e-6 * scale:
            rows += [(z, before), (z, after)]
        else:
            rows.append((z, _total(laws, z)))
    displacement, force = np.array(rows).T
    return displacement, force


def _total(laws: Sequence[_Law], z: float) -> float:
    return float(sum(law.force(np.array([z]))[0] for law in laws))


def check_places(model: Model, places: Sequence[str]) -> None:
    """Pass names of masses.

    Raises
    ------
    ModelError
        If the model has no such mass.
    """
    for place in places:
        if place == BASE or place not in model.masses:
            raise ModelError(f"no mass {place!r}; the model has {', '.join(model.masses)}")
