"""Modes of files as structures, and structures as modes of files."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.exchange.mode_table import ModeTable
from shakerproc.geometry import Place
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
    told = {axis: participations_of(table, axis) for axis in axes}
    return replace(
        table,
        places=tuple(points),
        shapes=table.shapes[[row_of[place] for place in points.values()]],
        participations={axis: share for axis, share in told.items() if share is not None},
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
    found = tuple(
        StructureMode(
            float(table.frequencies[i]),
            float(damping[i]) if table.frequencies[i] else 0.0,
            tuple(shape),
            None if turned is None else float(turned[i]),
        )
        for i, shape in enumerate(shapes)
        if np.any(shape)
    )
    return found, shares


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
