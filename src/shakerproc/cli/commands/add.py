"""``shakerproc add``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc import files
from shakerproc.cli import options, output
from shakerproc.cli.commands.effects import complete_kind
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from shakerproc.diagnosis.adding import Added


def add(
    effect: Annotated[
        str,
        typer.Argument(
            metavar="EFFECT", help="Effect to add, such as gap.", autocompletion=complete_kind
        ),
    ],
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="Model file (YAML).", exists=True)
    ],
    testlog: options.LogArgument,
    new: Annotated[Path, typer.Option("--output", "-o", metavar="NEW", help="New model file.")],
    between: Annotated[
        str | None,
        typer.Option(metavar="A,B", help="Its two places.", show_default="where it fits best"),
    ] = None,
    force: Annotated[
        bool,
        typer.Option("--force", help="Write the model even where its error does not fall."),
    ] = False,
    start: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBER=VALUE",
            help="Where its fit may start besides, such as clearance=0.1mm.",
            show_default="what the tests suggest",
        ),
    ] = None,
    scaled_by: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CONDITION=VALUE",
            help="Condition of the tests that its force is proportional to, and the value at "
            "which its numbers shall hold, such as voltage=2V.",
            show_default="the same in all tests",
        ),
    ] = None,
    modes: Annotated[
        bool,
        typer.Option("--modes", help="Write further linear modes that were fitted, too."),
    ] = False,
    effects: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Fit an effect to a log; write it into a new model file.

    The old file is kept. Nothing is written where the held-out error does not fall by more than
    its standard error.
    """
    from shakerproc.cli.messages import announce
    from shakerproc.diagnosis.wanted import Wanted
    from shakerproc.model_files import read_model_file
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows import updated_model
    from shakerproc.workflows.arguments import GivenModel

    options.check_order(model, testlog)
    if new.resolve() == model.resolve():
        raise typer.BadParameter("NEW must be another file than MODEL", param_hint="-o")
    files.checked_folder(new.parent)
    log, known = read_testlog(testlog), read_model_file(model)
    with options.usage(effect="EFFECT"):
        updated_model.check_kind(effect)
        parts = None if between is None else [part.strip() for part in between.split(",")]
        places = None if parts is None else updated_model.places_of(parts, known.model)
    announce()
    with options.usage():
        numbers = updated_model.start_of(effect, _pairs(start or []))
        scale = updated_model.scale_of(_pairs(scaled_by)) if scaled_by else None
    once = output.Once()
    with output.progress("add", 3) as advance:
        updated = updated_model.fitted_effect(
            Wanted(effect, places, numbers, scale),
            GivenModel(known.model, known),
            log,
            effect_hashes=options.effects_of(effects).get("effects_sha256", {}),
            progress=advance,
            warn=once.warning,
        )
    if not force:
        updated_model.check_gain(effect, updated.added)
    if updated.added.worse:
        output.warning(f"written although {updated.added.worse}")
    for note in updated.added.notes:
        once.message(note)
    updated.save(new, modes=modes)
    _tell(effect, updated.added, new, json)
    output.next_step("see whether the error has fallen", "compare", new, testlog)


def _pairs(given: list[str]) -> dict[str, str]:
    """Return names and values of texts such as ``clearance=0.1mm``."""
    parted = [text.partition("=") for text in given]
    return {name.strip(): value.strip() for name, _, value in parted}


def _tell(effect: str, added: "Added", new: Path, json: str | None) -> None:
    from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS

    held = added.errors.held_out
    output.data(
        f"{effect} between {' and '.join(added.element.between)}: held-out error "
        f"{numeral(held.before)} -> {numeral(held.after)}, written to {new}"
    )
    rows = [[name, *p.row] for name, p in added.parameters.items()]
    if rows:
        columns = ["parameter", *ESTIMATE_COLUMNS]
        output.print_table(columns, rows)
    output.write_json(
        {
            "schema": "shakerproc-add/1",
            "kind": effect,
            "between": list(added.element.between),
            "parameters": {name: p.as_json() for name, p in added.parameters.items()},
            "linear": {name: p.as_json() for name, p in added.linear.items()},
            "held_out": held.as_json(),
            "errors": added.errors.as_json(),
            "notes": list(added.notes),
            "left_out": list(added.left_out),
            "worse": added.worse,
            "model": str(new),
        },
        json,
    )
