"""The geometry of a log: nodes, lines and surfaces, written in it or in a file beside it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from shakerproc.data import ChannelUse
from shakerproc.documents import Key
from shakerproc.errors import LogError
from shakerproc.geometry import LEAST, Place, Wireframe, problem_of
from shakerproc.geometry.data_sets import UffError
from shakerproc.geometry.universal import read_wireframe
from shakerproc.testlog.fields import Below, MisfitError, csv_cells
from shakerproc.testlog.schema import ChannelSection, GeometrySection
from shakerproc.units import quoted, to_si

LARGEST: Final = 100_000_000
"""Largest file that is read; a mesh of a million nodes has that much [byte]."""

_UNIVERSAL: Final = (".uff", ".unv", ".uf58")
_HEADER: Final = re.compile(
    r"(?P<name>node|x|y|z)\s*(?:[\[(](?P<unit>.*)[\])])?", re.IGNORECASE
)
_WANTED: Final = '"node,x [mm],y [mm],z [mm]"'


def geometry_of(section: str | GeometrySection | None, folder: Path) -> Wireframe | None:
    """Return the geometry of a log, None where it has none.

    Raises
    ------
    MisfitError
        If a line or a surface has a node without coordinates.
    LogError
        If a file of it cannot be used.
    """
    if section is None:
        return None
    if isinstance(section, str):
        path = Below(folder).path(section)
        if path.suffix.lower() == ".csv":
            return Wireframe(_table(path))
        if path.suffix.lower() not in _UNIVERSAL:
            raise MisfitError(
                f"expected a file .uff, .unv or .csv, or nodes and lines, got {quoted(section)}"
            )
        return _universal(path)
    given = section.nodes
    nodes = _table(Below(folder).path(given)) if isinstance(given, str) else given
    for kind in LEAST:
        for number, one in enumerate(getattr(section, kind)):
            if problem := problem_of(nodes, kind, one):
                raise MisfitError(problem, kind, number)
    return Wireframe(nodes, section.lines, section.surfaces)


def _universal(path: Path) -> Wireframe:
    """Return the geometry of a universal file.

    Raises
    ------
    LogError
        If it cannot be used.
    """
    try:
        return read_wireframe(_content(path))
    except UffError as error:
        raise LogError(f"{path}: {error}") from error


def _content(path: Path) -> bytes:
    """Return the content of a file.

    Raises
    ------
    LogError
        If there is none, or it is too large.
    """
    if not path.is_file():
        raise LogError(f"{path}: no such file; put the geometry there")
    if path.stat().st_size > LARGEST:
        raise LogError(f"{path}: expected a geometry, got more than {LARGEST / 1e6:g} MB")
    return path.read_bytes()


def _table(path: Path) -> dict[int, Place]:
    """Return the nodes of a table [m].

    Raises
    ------
    LogError
        If it is none; the line is named.
    """
    filled = [row for row in csv_cells(_content(path), path, comments=True) if any(row[1])]
    if not filled:
        raise LogError(f"{path}: expected a header {_WANTED}, got an empty file")
    columns, unit = _columns(path, *filled[0])
    nodes: dict[int, Place] = {}
    for line, cells in filled[1:]:
        number, *texts = (cells[at] if at < len(cells) else "" for at in columns)
        place = f"{path}:{line}"
        if not re.fullmatch(r"[1-9]\d{0,8}", number):
            raise LogError(f"{place}: expected the number of a node, got {quoted(number)}")
        if "" in texts:
            raise LogError(f"{place}: node {number} has no {'xyz'[texts.index('')]}")
        if int(number) in nodes:
            raise LogError(f"{place}: node {number} stands twice")
        try:
            x, y, z = (to_si(f"{text.replace(',', '.')} {unit}", "m") for text in texts)
        except ValueError as error:
            raise LogError(f"{place}: node {number}: {error}") from error
        nodes[int(number)] = (x, y, z)
    return nodes


def _columns(path: Path, line: int, header: Sequence[str]) -> tuple[tuple[int, ...], str]:
    """Return where node, x, y and z stand, and the unit of the coordinates.

    Raises
    ------
    LogError
        If a column is missing, or the coordinates have no unit or several.
    """
    found: dict[str, tuple[int, str]] = {}
    for at, cell in enumerate(header):
        if match := _HEADER.fullmatch(cell):
            found.setdefault(match["name"].lower(), (at, (match["unit"] or "").strip()))
    got = ", ".join(header)
    if found.keys() != {"node", "x", "y", "z"}:
        raise LogError(f"{path}:{line}: expected a header {_WANTED}, got {quoted(got)}")
    units = dict.fromkeys(found[name][1] for name in "xyz")
    if len(units) > 1 or "" in units:
        told = " and ".join(unit or "none" for unit in units)
        raise LogError(
            f"{path}:{line}: expected one unit for x, y and z, as in {_WANTED}, got {told}"
        )
    return tuple(found[name][0] for name in ("node", "x", "y", "z")), next(iter(units))


def seated(
    uses: Sequence[ChannelUse],
    sections: Mapping[Key, ChannelSection],
    wireframe: Wireframe | None,
) -> tuple[ChannelUse, ...]:
    """Return channels with the positions of their nodes, directions turned as these are.

    Raises
    ------
    MisfitError
        If a node is not of the geometry, or a position stands beside it.
    """
    return tuple(_at_node(use, sections[use.key].node, wireframe) for use in uses)


def _at_node(use: ChannelUse, node: int | None, wireframe: Wireframe | None) -> ChannelUse:
    """Return a channel at its node.

    Raises
    ------
    MisfitError
        If it cannot be.
    """
    if node is None:
        return use
    if use.position is not None:
        raise MisfitError("expected node or position, not both", use.key, "node")
    if wireframe is None:
        raise MisfitError(
            "expected geometry: beside channels:, which says where the nodes are",
            use.key,
            "node",
        )
    if problem := problem_of(wireframe.nodes, "node", (node,)):
        raise MisfitError(problem, use.key, "node")
    along = use.direction and wireframe.turned(node, use.direction)
    return replace(use, position=wireframe.nodes[node], direction=along)
