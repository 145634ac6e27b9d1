"""``shakerproc add``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output
from shakerproc.cli.commands.effects import complete_kind

if TYPE_CHECKING:
    from shakerproc.diagnosis.adding import Added
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
    start: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBER=VALUE",
            help="Where its fit may start besides, such as clearance=0.1mm.",
            show_default="what the tests suggest",
        ),
    ] = None,
    modes: Annotated[
        bool,
        typer.Option("--modes", help="Write further linear modes that were fitted, too."),
    ] = False,
    own: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Fit an effect to a log and write it into a new model file; the old one is kept.

    Nothing is written where the held-out error does not fall by more than its standard error.
    """
    from shakerproc.cli.compiling import announce
    from shakerproc.model_files import add_element, read_model_file
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.judging import add_effect

    options.check_order(model, testlog)
    if new.resolve() == model.resolve():
        raise typer.BadParameter("NEW must be another file than MODEL", param_hint="-o")
    output.checked_folder(new.parent)
    log, known = read_testlog(testlog), read_model_file(model).model
    _check_kind(effect)
    places = None if between is None else _places(between, known)
    announce()
    numbers = _start(effect, start or [])
    with output.progress("add", 3) as advance:
        added = add_effect(
            effect, known, log, between=places, start=numbers, force=True, progress=advance
        )
    _judge(effect, added, force=force)
    joint = " to ".join(added.element.between)
    add_element(
        model,
        added.element,
        new,
        _provenance(log, added, options.effects_of(own)),
        changes=_changes(known, added.model),
        masses={n: m for n, m in added.model.masses.items() if m != known.masses[n]},
        modes=added.modes if modes else (),
        title=f"{known.title}, with {effect.replace('_', ' ')} ({joint})",
    )
    _tell(effect, added, new, json)


def _judge(effect: str, added: "Added", *, force: bool) -> None:
    """Say what must be known of a fit before it is written.

    Raises
    ------
    DiagnosisError
        If it is no gain, and not forced.
    """
    from shakerproc.errors import DiagnosisError

    for text in added.left_out:
        output.warning(text)
    if added.worse and not force:
        raise DiagnosisError(
            f"{effect} between {' and '.join(added.element.between)}: {added.worse}. No model "
            "is written; --force writes it all the same."
        )
    if added.worse:
        output.warning(f"written although {added.worse}")
    for note in added.notes:
        output.message(note)


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


def _changes(known: "Model", new: "Model") -> dict[int, dict[str, float]]:
    """Return the numbers of a model that another has changed, by the number of the element."""
    changes = {
        i: {
            name: getattr(other.effect, name)
            for name in own.effect.parameters
            if getattr(other.effect, name) != getattr(own.effect, name)
        }
        for i, (own, other) in enumerate(zip(known.elements, new.elements, strict=False))
    }
    return {i: values for i, values in changes.items() if values}


def _start(effect: str, given: list[str]) -> dict[str, float | str]:
    """Return numbers to start from [SI].

    Raises
    ------
    typer.BadParameter
        If one is not written as a number of the effect with its unit.
    """
    from shakerproc.models import EFFECTS
    from shakerproc.units import to_si

    known = EFFECTS[effect].estimated()
    found: dict[str, float | str] = {}
    for text in given:
        name, _, value = text.partition("=")
        parameter = known.get(name.strip())
        if parameter is None:
            raise typer.BadParameter(
                f"{effect} has no number {name.strip()!r}; it has {', '.join(known)}",
                param_hint="--start",
            )
        if parameter.choices:
            found[name.strip()] = value.strip()
            continue
        try:
            found[name.strip()] = to_si(value.strip(), parameter.unit)
        except ValueError as error:
            raise typer.BadParameter(f"{name}: {error}", param_hint="--start") from error
    return found


def _tell(effect: str, added: "Added", new: Path, json: str | None) -> None:
    held = added.errors.held_out
    output.data(
        f"{effect} between {' and '.join(added.element.between)}: held-out error "
        f"{held.before:.3g} -> {held.after:.3g}, written to {new}",
        json_target=json,
    )
    rows = [[name, p.value, p.low, p.high, p.unit] for name, p in added.parameters.items()]
    if rows:
        columns = ["parameter", "value", "low", "high", "unit"]
        output.print_table(columns, rows, json_target=json)
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
