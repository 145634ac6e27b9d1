"""``shakerproc add``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output
from shakerproc.cli.commands.effects import complete_kind

if TYPE_CHECKING:
    from shakerproc.diagnose.adding import Added
    from shakerproc.model_files import Provenance
    from shakerproc.models import Model
    from shakerproc.testlog import TestLog


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
    own: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Fit an effect to a log and write it into a new model file; the old one is kept.

    Nothing is written where the held-out error does not fall.
    """
    from shakerproc.cli.compiling import announce
    from shakerproc.diagnose.adding import fit_effect
    from shakerproc.errors import DiagnosisError
    from shakerproc.model_files import add_element, read_model_file
    from shakerproc.testlog import read_testlog

    options.check_order(model, testlog)
    if new.resolve() == model.resolve():
        raise typer.BadParameter("NEW must be another file than MODEL", param_hint="-o")
    output.checked_folder(new.parent)
    log, known = read_testlog(testlog), read_model_file(model).model
    _check_kind(effect)
    places = None if between is None else _places(between, known)
    announce()
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
    element = added.in_few_digits()
    title = f"{known.title}, with {effect.replace('_', ' ')} ({' to '.join(element.between)})"
    changes = _changes(known, added)
    add_element(
        model,
        element,
        new,
        _provenance(log, added, options.effects_of(own)),
        changes=changes,
        title=title,
    )
    _tell(effect, added, new, json)


def _provenance(log: "TestLog", added: "Added", own: dict[str, dict[str, str]]) -> "Provenance":
    """Return where the fitted numbers come from, as the model file says it."""
    import datetime

    from shakerproc import __version__
    from shakerproc.model_files import Provenance

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
    hashes |= own.get("effects_sha256", {})
    today = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    return Provenance(added.tests, hashes, spans, f"shakerproc {__version__}", today)


def _changes(known: "Model", added: "Added") -> dict[int, dict[str, float]]:
    """Return the springs and dampers that were fitted as well, by the number of the element."""
    from shakerproc.diagnose.adding import shortened

    changes: dict[int, dict[str, float]] = {}
    for i, own in enumerate(known.elements):
        place = _place(own.between, added.stiffness)
        if place is None or not _alone(known, i):
            continue
        if own.effect.kind == "spring":
            changes[i] = {"stiffness": float(shortened(added.stiffness[place]))}
        elif own.effect.kind == "damper" and getattr(own.effect, "damping", None) is not None:
            changes[i] = {"damping": float(shortened(added.damping[place]))}
    return changes


def _tell(effect: str, added: "Added", new: Path, json: str | None) -> None:
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


def _check_kind(effect: str) -> None:
    """Refuse an effect that there is not.

    Raises
    ------
    typer.BadParameter
        If there is none of that name.
    """
    from shakerproc.models import EFFECTS
    from shakerproc.units import near_miss

    if effect not in EFFECTS:
        meant = near_miss(effect, list(EFFECTS))
        question = f"; did you mean {meant}?" if meant else f"; there are {', '.join(EFFECTS)}"
        raise typer.BadParameter(f"no effect {effect!r}{question}", param_hint="EFFECT")


def _places(between: str, model: "Model") -> list[str]:
    """Return two places of a model.

    Raises
    ------
    typer.BadParameter
        If they are not two of its places.
    """
    from shakerproc.models import BASE

    there = [BASE, *model.masses]
    places = [part.strip() for part in between.split(",")]
    unknown = [place for place in places if place not in there]
    if unknown:
        raise typer.BadParameter(
            f"{model.title} has no place {unknown[0]!r}; there are {', '.join(there)}",
            param_hint="--between",
        )
    if len(places) != 2 or places[0] == places[1]:
        raise typer.BadParameter(
            f"expected two places such as {there[0]},{there[1]}, got {between!r}",
            param_hint="--between",
        )
    return places


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
