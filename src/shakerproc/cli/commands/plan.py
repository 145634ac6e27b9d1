"""``shakerproc plan``."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from shakerproc.planning import AbstractJoint, PlannedTest, PlanWish, ShakerLimits, Warming
    from shakerproc.testlog import Shaker, Test, TestLog


def plan(
    testlog: options.LogArgument,
    model: Annotated[
        Path | None,
        typer.Option(metavar="MODEL", help="Model (YAML).", exists=True, dir_okay=False),
    ] = None,
    joint: Annotated[
        str | None,
        typer.Option(
            metavar="PLACE,PLACE",
            help="Which joint of the model has the play.",
            show_default="its first gap, else its first element on the base",
        ),
    ] = None,
    clearance: Annotated[
        str, typer.Option(metavar="actual|nominal", help="Which clearance of the log counts.")
    ] = "actual",
    coupon: Annotated[
        Path | None,
        typer.Option(
            metavar="COUPON", help="Coupon (YAML) with its joint.", exists=True, dir_okay=False
        ),
    ] = None,
    temperature: Annotated[
        str | None,
        typer.Option(
            metavar="TEMPERATURE", help='Of the test, such as "-40 degC"; with --coupon.'
        ),
    ] = None,
    max_g: Annotated[
        float | None, typer.Option(help="Largest acceleration of the shaker, peak [g].")
    ] = None,
    max_velocity_m_per_s: Annotated[
        float | None, typer.Option(help="Largest velocity of the shaker, peak [m/s].")
    ] = None,
    max_displacement_mm: Annotated[
        float | None,
        typer.Option(help="Largest displacement of the shaker, peak: half its stroke [mm]."),
    ] = None,
    sample_rate_hz: Annotated[
        float | None,
        typer.Option(help="Sample rate of tests whose log does not state it [Hz]."),
    ] = None,
    duration_s: Annotated[
        float | None, typer.Option(help="Duration of tests whose log does not state it [s].")
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Diagnosis (JSON): plan the tests that it asks for too.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    rehearse: Annotated[
        bool,
        typer.Option("--rehearse", help="Simulate the campaign too; with --model."),
    ] = False,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Predict how far tests move, and whether play is used up.

    The table moves a0 / (4 pi^2 f^2); a part that stays at rest is hit on both sides where that
    is more than half the play. With a model the joint's own motion counts, resonances and all;
    until the first contact it is linear, so levels and frequencies are exact. Random motion is
    judged by 3 sigma, the shaker's limits (shaker: in the log) too.
    """
    from shakerproc.planning import PlanWish, plan_campaign
    from shakerproc.testlog import read_testlog

    log = read_testlog(testlog)
    if diagnosis is not None:
        log = replace(log, tests=(*log.tests, *_suggested(diagnosis, log)))
    if rehearse and model is None:
        raise typer.BadParameter("needs --model", param_hint="--rehearse")
    wish = PlanWish(
        joint=_joint(model, joint),
        limits=_limits(log.shaker, max_g, max_velocity_m_per_s, max_displacement_mm),
        which=_which(clearance),
        warming=_warming(coupon, temperature),
        sample_rate=_positive(sample_rate_hz, "--sample-rate-hz"),
        duration=_positive(duration_s, "--duration-s"),
    )
    plans = plan_campaign(log, wish)
    folder = output.out_folder(out, f"{testlog.stem}_plan")
    with output.results(folder, "plan"):
        _write(plans, wish, log.title, folder, figures=figures)
    output.write_json(_document(testlog, model, log.title, plans), json)
    _print(plans, wish, folder)
    if rehearse and model is not None:
        _rehearse(model, testlog, folder / "rehearsal")
    output.message(f"results in {folder}")


def _suggested(diagnosis: Path, log: "TestLog") -> "tuple[Test, ...]":
    """Return the tests that a diagnosis asks for.

    Raises
    ------
    LogError
        If the file is no diagnosis.
    """
    from json import JSONDecodeError, loads

    from shakerproc.errors import LogError
    from shakerproc.planning import suggested_tests

    try:
        document = loads(diagnosis.read_text(encoding="utf-8"))
    except (JSONDecodeError, UnicodeDecodeError) as error:
        raise LogError(
            f"{diagnosis}: no JSON: {error}; write it with diagnose --json"
        ) from error
    tests = suggested_tests(document, log, str(diagnosis))
    if not tests:
        output.message(f"{diagnosis} asks for no further test")
    return tests


def _rehearse(model: Path, testlog: Path, folder: Path) -> None:
    """Simulate the campaign, as simulate does with its defaults."""
    from shakerproc.model_files import read_model
    from shakerproc.planning import Staging
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.simulation import rehearse_campaign

    log = read_testlog(testlog)
    with output.progress("simulate", len(log.active)) as advance:
        recordings = rehearse_campaign(
            read_model(model), log, Staging(),
            folder=folder, overwrite=True, advance=advance, warn=output.warning,
        )  # fmt: skip
    output.message(
        f"{len(recordings)} recordings simulated: shakerproc batch {folder / testlog.name}"
    )


def _joint(model: Path | None, joint: str | None) -> "AbstractJoint":
    """Return the joint whose parts move against each other.

    Raises
    ------
    typer.BadParameter
        If a joint is named without a model, or not by two places.
    """
    from shakerproc.model_files import read_model
    from shakerproc.planning import FreeJoint, joint_of_model

    if model is None:
        if joint is not None:
            raise typer.BadParameter("needs --model", param_hint="--joint")
        return FreeJoint()
    if joint is None:
        return _with_notes_said(joint_of_model(read_model(model)))
    places = [place.strip() for place in joint.split(",")]
    if len(places) != 2:
        raise typer.BadParameter(
            f"expected two places such as base,coupon, not {joint!r}", param_hint="--joint"
        )
    return _with_notes_said(joint_of_model(read_model(model), (places[0], places[1])))


def _with_notes_said(joint: "AbstractJoint") -> "AbstractJoint":
    for note in getattr(joint, "notes", ()):
        output.warning(note)
    return joint


def _which(clearance: str) -> Literal["actual", "nominal"]:
    """Return which clearance counts.

    Raises
    ------
    typer.BadParameter
        If it is neither.
    """
    if clearance == "actual":
        return "actual"
    if clearance == "nominal":
        return "nominal"
    raise typer.BadParameter(
        f"{clearance!r} is not one of actual, nominal", param_hint="--clearance"
    )


def _positive(value: float | None, option: str) -> float | None:
    """Return a value above 0, or None.

    Raises
    ------
    typer.BadParameter
        If it is not above 0.
    """
    if value is not None and not 0.0 < value < inf:
        raise typer.BadParameter(f"must be above 0, not {value:g}", param_hint=option)
    return value


def _limits(
    shaker: "Shaker",
    max_g: float | None,
    max_velocity: float | None,
    max_displacement_mm: float | None,
) -> "ShakerLimits":
    """Return the limits of the shaker: those of the log, set aside by the options."""
    from shakerproc.data import STANDARD_GRAVITY
    from shakerproc.planning import ShakerLimits

    acceleration = _positive(max_g, "--max-g")
    displacement = _positive(max_displacement_mm, "--max-displacement-mm")
    half_stroke = None if shaker.stroke is None else 0.5 * shaker.stroke
    return ShakerLimits(
        _first(
            None if acceleration is None else acceleration * STANDARD_GRAVITY,
            shaker.acceleration,
        ),
        _first(_positive(max_velocity, "--max-velocity-m-per-s"), shaker.velocity),
        _first(None if displacement is None else 1e-3 * displacement, half_stroke),
        _first(shaker.force),
        shaker.moving_mass or 0.0,
    )


def _first(*values: float | None) -> float:
    """Return the first limit that is known, else that there is none."""
    return next((value for value in values if value is not None), inf)


def _warming(coupon: Path | None, temperature: str | None) -> "Warming | None":
    """Return how the joint expands, None where no temperature is asked for.

    Raises
    ------
    typer.BadParameter
        If one option lacks the other, or the coupon says nothing of its joint.
    """
    from shakerproc.model_files.coupon_files import read_coupon
    from shakerproc.planning import Warming
    from shakerproc.units import to_si

    if temperature is None and coupon is None:
        return None
    if temperature is None or coupon is None:
        raise typer.BadParameter(
            "--temperature and --coupon go together", param_hint="--temperature"
        )
    coupon_file = read_coupon(coupon)
    if coupon_file.fit is None:
        raise typer.BadParameter(
            f"{coupon} has no joint: the bushing's size and material", param_hint="--coupon"
        )
    with options.refused("--temperature"):
        kelvin = to_si(temperature, "K")
    if kelvin <= 0.0:
        raise typer.BadParameter(
            f"{temperature} is below absolute zero", param_hint="--temperature"
        )
    return Warming(
        coupon_file.fit, coupon_file.coupon.thickness, kelvin - coupon_file.reference
    )


def _write(
    plans: "Sequence[PlannedTest]", wish: "PlanWish", title: str, folder: Path, *, figures: bool
) -> None:
    from shakerproc import files
    from shakerproc.planning import plan_columns

    files.write_csv(folder / "plan.csv", plan_columns(plans))
    if figures and any(planned.shaken is not None for planned in plans):
        from shakerproc.report.figures import style
        from shakerproc.report.figures.to_png import save
        from shakerproc.report.models.curves import plan_figure

        with style.look():
            made = plan_figure(plans, wish.joint, wish.limits, title)
            save(made, folder / "displacement.png")


def _document(
    log: Path, model: Path | None, title: str, plans: "Sequence[PlannedTest]"
) -> dict[str, object]:
    import hashlib

    from shakerproc import __version__
    from shakerproc.planning import plan_documents

    inputs = [path for path in (log, model) if path is not None]
    return {
        "schema": "shakerproc-plan/1",
        "shakerproc": __version__,
        "title": title,
        "inputs": {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in inputs},
        "tests": plan_documents(plans),
    }


def _print(plans: "Sequence[PlannedTest]", wish: "PlanWish", folder: Path) -> None:
    from shakerproc.planning import FreeJoint

    moving = "table" if isinstance(wish.joint, FreeJoint) else "joint"
    output.print_table(
        (
            "test",
            "joint",
            "excitation",
            "level",
            "from [Hz]",
            "to [Hz]",
            "takes [s]",
            "table [mm]",
            "play ± [mm]",
            *(("joint [mm]",) if moving == "joint" else ()),
            "contact",
            "both sides at [Hz]",
            "both sides from",
            "averages",
            "remarks",
        ),
        [_row(planned, moving) for planned in plans if not planned.test.discarded],
        spare=("averages", "takes [s]", "remarks", "from [Hz]", "to [Hz]", "joint"),
        elsewhere=str(folder / "plan.csv"),
    )
    discarded = sum(planned.test.discarded for planned in plans)
    both = sum(p.reach is not None and p.reach.contact == "both sides" for p in plans)
    known = sum(p.reach is not None for p in plans)
    output.data(
        f"{len(plans) - discarded} tests, {discarded} discarded; {both} of {known} whose play "
        f"is known use it up on both sides ({moving})"
    )
    for text, tests in _remarks(plans).items():
        output.data(f"test {', '.join(tests)}: {text}")


def _remarks(plans: "Sequence[PlannedTest]") -> dict[str, list[str]]:
    """Return every remark with the tests that it is about."""
    columns: dict[str, list[str]] = {}
    for planned in plans:
        for text in planned.warnings:
            columns.setdefault(text, []).append(str(planned.test.id))
    return columns


def _row(planned: "PlannedTest", moving: str) -> tuple[object, ...]:
    from shakerproc.planning import bands_text

    test, shaken, reach, walls = planned.test, planned.shaken, planned.reach, planned.walls
    travel = planned.travel
    return (
        test.id,
        test.joint,
        test.excitation,
        test.level_text,
        shaken.low if shaken else None,
        shaken.high if shaken else None,
        planned.duration,
        1e3 * travel.motion.displacement if travel else None,
        1e3 * walls.far if walls else None,
        *((1e3 * reach.displacement if reach else None,) if moving == "joint" else ()),
        reach.contact if reach else None,
        bands_text(reach.both_sides_hz) if reach else None,
        planned.needed.text if planned.needed else None,
        planned.averaging.averages if planned.averaging else None,
        len(planned.warnings) or None,
    )
