"""``shakerproc add``."""

from pathlib import Path
from typing import Annotated

import typer

from shakerproc.cli import options, output
from shakerproc.cli.commands.effects import complete_kind


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
    json: output.JsonOption = None,
) -> None:
    """Fit an effect to a log and write it into a new model file; the old one is kept.

    Nothing is written where the held-out error does not fall.
    """
    import datetime

    from shakerproc import __version__
    from shakerproc.cli.compiling import announce
    from shakerproc.diagnose.adding import fit_effect
    from shakerproc.errors import DiagnosisError
    from shakerproc.model_files import Provenance, add_element, read_model_file
    from shakerproc.testlog import read_testlog

    announce()
    if new.resolve() == model.resolve():
        raise typer.BadParameter("NEW must be another file than MODEL", param_hint="-o")
    output.checked_folder(new.parent)
    log, known = read_testlog(testlog), read_model_file(model).model
    places = None if between is None else [part.strip() for part in between.split(",")]
    with output.progress("add", 3) as advance:
        added = fit_effect(effect, known, log, between=places, progress=advance)
    for text in added.left_out:
        output.warning(text)
    if added.worse and not force:
        raise DiagnosisError(
            f"{effect} between {' and '.join(added.element.between)}: {added.worse}. No model "
            "is written; --force writes it all the same."
        )
    if added.worse:
        output.warning(f"written although {added.worse}")
    spans = {
        name: (p.low, p.high)
        for name, p in added.parameters.items()
        if p.low is not None and p.high is not None
    }
    hashes = {
        f"{test.recording.parent.name}/{test.recording.name}": added.sha256[str(test.id)]
        for test in log.tests
        if test.recording is not None and str(test.id) in added.tests
    }
    changes: dict[int, dict[str, float]] = {}
    for i, element in enumerate(known.elements):
        place = _place(element.between, added.stiffness)
        if place is None:
            continue
        if element.effect.kind == "spring" and _alone(known, i):
            changes[i] = {"stiffness": float(added.stiffness[place].value)}
        damping = getattr(element.effect, "damping", None)
        if element.effect.kind == "damper" and damping is not None and _alone(known, i):
            changes[i] = {"damping": float(added.damping[place].value)}
    today = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    source = Provenance(added.tests, hashes, spans, f"shakerproc {__version__}", today)
    add_element(model, added.element, new, source, changes=changes)
    output.data(
        f"{effect} between {' and '.join(added.element.between)}: held-out error "
        f"{added.before:.3g} -> {added.after:.3g}, written to {new}",
        json_target=json,
    )
    rows = [[name, p.value, p.low, p.high, p.unit] for name, p in added.parameters.items()]
    output.print_table(["parameter", "value", "low", "high", "unit"], rows, json_target=json)
    output.write_json(
        {
            "schema": "shakerproc-add/1",
            "kind": effect,
            "between": list(added.element.between),
            "parameters": {name: p.as_json() for name, p in added.parameters.items()},
            "held_out": {"before": added.before, "after": added.after},
            "left_out": list(added.left_out),
            "worse": added.worse,
            "model": str(new),
        },
        json,
    )


def _place(between, known):  # type: ignore[no-untyped-def]
    return next((place for place in known if set(place) == set(between)), None)


def _alone(model, index):  # type: ignore[no-untyped-def]
    """Return whether an element is the only one of its kind between its places."""
    own = model.elements[index]
    same = [
        e for e in model.elements
        if e.effect.kind == own.effect.kind and set(e.between) == set(own.between)
    ]  # fmt: skip
    return len(same) == 1
