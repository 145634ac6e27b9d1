"""``shakerproc effects``."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from shakerproc.cli import options, output, tables

if TYPE_CHECKING:
    from collections.abc import Mapping

    from shakerproc.workflows.effect_list import Kind

_BLANK: Final = 0x2800
_DOTS: Final = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


def can_be_shown() -> bool:
    """Return whether stdout is a terminal that has such characters."""
    encoding = (getattr(sys.stdout, "encoding", "") or "").lower().replace("-", "")
    return sys.stdout.isatty() and encoding == "utf8" and os.environ.get("TERM") != "dumb"


def curve(x: Sequence[float], y: Sequence[float], columns: int, rows: int) -> str:
    """Return a curve, with the origin in the middle, as lines of characters.

    Parameters
    ----------
    x, y : sequence of float
        Points along the curve, close to each other.
    columns, rows : int
        Size of the picture in characters.
    """
    wide, high = 2 * columns - 1, 4 * rows - 1
    cells = [[0] * columns for _ in range(rows)]
    largest_x = max(map(abs, x)) or 1.0
    largest_y = max(map(abs, y)) or 1.0
    for across, up in zip(x, y, strict=True):
        column = round((across / largest_x + 1.0) / 2.0 * wide)
        row = round((1.0 - up / largest_y) / 2.0 * high)
        cells[row // 4][column // 2] |= _DOTS[row % 4][column % 2]
    return "\n".join("".join(chr(_BLANK + cell) for cell in line) for line in cells)


def complete_kind(incomplete: str) -> list[str]:
    """Return the effects and faults that begin so, for the Tab key."""
    from shakerproc.workflows.effect_list import known_kinds

    return [kind for kind in known_kinds() if kind.startswith(incomplete)]


def effects(
    kind: Annotated[
        str | None,
        typer.Argument(
            metavar="EFFECT", help="One effect; by default all.", autocompletion=complete_kind
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option("-o", "--figure", metavar="FILE", help="Picture of the one (PNG)."),
    ] = None,
    own_effects: options.EffectsOption = None,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """List the laws of force and the faults that a model may have.

    Of one effect: formula, parameters with their units, what betrays it, where it comes from,
    and with -o a picture of its loop and of what it makes of stiffness and damping as the
    level rises. With --out a folder with the pictures of all, and a page that shows them.
    """
    from shakerproc.workflows.effect_list import effects as listed
    from shakerproc.workflows.effect_list import known_kinds

    known = known_kinds()
    if kind is not None and kind not in known:
        raise typer.BadParameter(_unknown(kind, list(known)), param_hint="EFFECT")
    if figure is not None and kind is None:
        raise typer.BadParameter("needs the name of one effect", param_hint="-o")
    chosen = known if kind is None else {kind: known[kind]}
    documents = {name: one for name, one in listed().items() if name in chosen}
    output.write_json(
        {
            "schema": "shakerproc-effects/1",
            "effects": documents,
            **options.effects_of(own_effects),
        },
        json,
    )
    if kind is None:
        _print_all(known)
    else:
        _print_one(kind, documents[kind])
    if figure is not None and kind is not None:
        _draw(kind, figure)
        output.message(f"{figure}")
    if out is not None:
        for name in chosen:
            _draw(name, out / f"{name}.png")
        _write_page(documents, out)
        output.message(f"{len(chosen)} pictures in {out}")


def _unknown(kind: str, known: list[str]) -> str:
    from shakerproc.units import near_miss

    meant = near_miss(kind, known)
    question = f"; did you mean {meant}?" if meant else "."
    return f"no effect {kind!r}{question} There are {', '.join(known)}."


def _print_all(known: "Mapping[str, Kind]") -> None:
    from shakerproc.models import FAULTS

    columns: tuple[str, ...] = ("effect", "force", "parameters")
    rows: list[tuple[object, ...]] = [
        (k, o.formula, ", ".join(o.parameters)) for k, o in known.items() if k not in FAULTS
    ]
    if can_be_shown():
        columns = ("effect", "loop", *columns[1:])
        rows = [(k, tables.Picture(f"{_loop(str(k), 10, 2)}\n "), *more) for k, *more in rows]
    output.print_table(columns, rows, spare=("parameters",))
    output.data("")
    output.print_table(
        ("fault", "what is recorded of u", "parameters"),
        [(k, o.formula, ", ".join(o.parameters)) for k, o in known.items() if k in FAULTS],
    )
    output.data("z and v: displacement and velocity of the second place against the first")


def _print_one(kind: str, document: "Mapping[str, object]") -> None:
    parameters, references = document["parameters"], document["references"]
    assert isinstance(parameters, dict)  # noqa: S101 - narrows the type
    assert isinstance(references, list)  # noqa: S101
    output.data(f"{kind}: {document['about']}")
    output.data(f"  {document['formula']}")
    if can_be_shown():
        _print_loop(kind)
    output.print_table(
        ("parameter", "symbol", "unit", "meaning", "must be", "force is linear in it"),
        [
            (
                name,
                one["symbol"],
                " or ".join(one["choices"]) or one["unit"],
                one["meaning"],
                ("" if one["choices"] else one["sign"])
                + (", may be left out" if one["optional"] else ""),
                "yes" if one["linear"] else "no",
            )
            for name, one in parameters.items()
        ],
    )
    output.data(f"signature: {document['signature']}")
    for text in references:
        output.data(f"reference: {text}")


def _print_loop(kind: str) -> None:
    """Print force over displacement, where the kind is a force."""
    from shakerproc.models import EFFECTS

    if kind in EFFECTS:
        output.data(f"\n{_loop(kind, 36, 9)}")
        output.data("force (up) over displacement (across), along a sine\n")


def _loop(kind: str, columns: int, rows: int) -> str:
    """Return the force over a cycle of displacement, as lines of characters."""
    from shakerproc.models.effects import StiffnessDrift, example_of
    from shakerproc.report.models.effects import LARGEST, cycle_of

    effect = example_of(kind)
    if isinstance(effect, StiffnessDrift) and effect.stiffness is None:
        effect = effect.in_place(1.2e5, 1.0)
    cycle = cycle_of(effect, LARGEST)
    return curve(cycle.displacement.tolist(), cycle.force.tolist(), columns, rows)


def _draw(kind: str, path: Path) -> None:
    from shakerproc.report.figures import style
    from shakerproc.report.figures.to_png import save
    from shakerproc.report.models.effects import picture

    with style.look():
        save(picture(kind), path)


def _write_page(documents: "Mapping[str, Mapping[str, object]]", folder: Path) -> None:
    """Write a page (Markdown) that shows every picture."""
    from shakerproc import files

    lines = ["# Effects", "", "Written by `shakerproc effects --out FOLDER`.", ""]
    for name, one in documents.items():
        lines += [f"## {name}", "", f"    {one['formula']}", "", f"{one['about']}", ""]
        parameters = one["parameters"]
        assert isinstance(parameters, dict)  # noqa: S101 - narrows the type
        if parameters:
            lines += ["| parameter | symbol | unit | meaning |", "|---|---|---|---|"]
            lines += [
                f"| {key} | {p['symbol']} | {' or '.join(p['choices']) or p['unit']} "
                f"| {p['meaning']} |"
                for key, p in parameters.items()
            ]
            lines.append("")
        lines += [f"{one['signature']}", "", f"![{name}]({name}.png)", ""]
        references = one["references"]
        assert isinstance(references, list)  # noqa: S101
        lines += [text for reference in references for text in (f"*{reference}*", "")]
    files.write_text(folder / "effects.md", "\n".join(lines))
