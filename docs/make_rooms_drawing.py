"""Draw docs/images/rooms.svg from the imports: python docs/make_rooms_drawing.py [--check]."""

import ast
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence, Set
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "shakerproc"
DRAWING = ROOT / "docs" / "images" / "rooms.svg"
WIDTH, HEIGHT, GAP, ROW = 104, 26, 22, 64  # of a room, between rooms, of a floor [px]
ASIDE = 96  # by which floors of one room stand left and right in turn: no line hides another
MARGIN = 12  # [px]


def floors() -> list[list[str]]:
    """Return the rooms of each floor, from the top: the contract that `lint-imports` checks."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    layers = project["tool"]["importlinter"]["contracts"][0]["layers"]
    return [line.replace("|", " ").split() for line in layers if line != "__main__"]


def imports(rooms: Set[str]) -> dict[str, set[str]]:
    """Return the rooms that each room imports, types among them."""
    found: dict[str, set[str]] = {room: set() for room in rooms}
    for path in sorted(SOURCE.rglob("*.py")):
        room = path.relative_to(SOURCE).parts[0].removesuffix(".py")
        if room in rooms:
            tree = ast.parse(path.read_text("utf-8"))
            found[room] |= {other for other in _imported(tree) if other in rooms - {room}}
    return found


def _imported(tree: ast.Module) -> Iterator[str]:
    """Yield the rooms that a file imports from."""
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            if name.startswith("shakerproc."):
                yield name.split(".")[1]


def reduced(direct: Mapping[str, set[str]]) -> list[tuple[str, str]]:
    """Return the imports that no way through other rooms implies (transitive reduction)."""

    def below(room: str) -> set[str]:
        return direct[room].union(*(below(other) for other in direct[room]))

    return sorted(
        (room, other)
        for room, others in direct.items()
        for other in others
        if not any(other in below(between) for between in others)
    )


def drawing() -> str:
    """Return the rooms as SVG: a floor for each layer, a line for each import.

    The lowest floor has none: nearly every room imports from it.
    """
    rows = floors()
    widest = max(map(len, rows))
    width = 2 * MARGIN + widest * (WIDTH + GAP) - GAP
    height = 2 * MARGIN + (len(rows) - 1) * ROW + HEIGHT
    places = {
        room: (
            width / 2
            + (i - (len(row) - 1) / 2) * (WIDTH + GAP)
            + (ASIDE if level % 2 else -ASIDE) * (len(row) == 1),
            MARGIN + level * ROW,
        )
        for level, row in enumerate(rows)
        for i, room in enumerate(row)
    }
    edges = [one for one in reduced(imports(places.keys())) if one[1] not in rows[-1]]
    return "\n".join((
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="12" text-anchor="middle">',
        "<title>Rooms of shakerproc and what they import</title>",
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        f'<path d="{_lines(edges, places)}" fill="none" stroke="#2f6aa0"/>',
        *(_room(room, *place) for room, place in places.items()),
        "</svg>\n",
    ))


def _lines(edges: Sequence[tuple[str, str]], places: Mapping[str, tuple[float, float]]) -> str:
    """Return a curve for each import, from the floor of one room to the ceiling of another."""
    curves = []
    for upper, lower in edges:
        (x, top), (end, bottom) = places[upper], places[lower]
        y, bend = top + HEIGHT, (bottom - top - HEIGHT) / 2
        curves.append(
            f"M{x:g} {y:g}C{x:g} {y + bend:g} {end:g} {bottom - bend:g} {end:g} {bottom:g}"
        )
    return "".join(curves)


def _room(name: str, x: float, y: float) -> str:
    return (
        f'<rect x="{x - WIDTH / 2:g}" y="{y:g}" width="{WIDTH}" height="{HEIGHT}" rx="4" '
        f'fill="#eef3f8" stroke="#5d8fbd"/><text x="{x:g}" y="{y + 17:g}">{escape(name)}</text>'
    )


def main() -> None:
    """Write the drawing, or with --check fail where it is not that of the imports."""
    if "--check" not in sys.argv:
        DRAWING.write_text(drawing(), encoding="utf-8")
    elif DRAWING.read_text(encoding="utf-8") != drawing():
        sys.exit("the imports have changed; run python docs/make_rooms_drawing.py")


if __name__ == "__main__":
    main()
