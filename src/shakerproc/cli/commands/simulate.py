"""``shakerproc simulate``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from shakerproc.models import Model
    from shakerproc.models.motion import Motion
    from shakerproc.planning import Staging

QUANTITIES = ("m/s^2", "N", "m", "m/s", "V")


def simulate(
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="Model (YAML).", exists=True, dir_okay=False)
    ],
    excitation: Annotated[
        Path,
        typer.Argument(
            metavar="TESTLOG|RECORDING",
            help="Test log (YAML), or a recording whose control signal shakes the model.",
            exists=True,
            dir_okay=False,
        ),
    ],
    tests: Annotated[
        str, typer.Option(metavar="ID,ID", help="Only these tests of the log.")
    ] = "",
    sample_rate_hz: Annotated[
        float,
        typer.Option(
            help="Sample rate of tests whose log does not state it [Hz].",
            min=1.0,
            max=1e9,
            callback=options.positive,
        ),
    ] = 5688.9,
    duration_s: Annotated[
        float,
        typer.Option(
            help="Duration of runs whose log does not state it [s].",
            min=0.01,
            callback=options.positive,
        ),
    ] = 10.0,
    lead_in_s: Annotated[
        float,
        typer.Option(help="Rest before the run [s].", min=0.0, callback=options.not_negative),
    ] = 0.5,
    lead_out_s: Annotated[
        float,
        typer.Option(help="Rest after the run [s].", min=0.0, callback=options.not_negative),
    ] = 0.5,
    noise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="VALUE",
            help='Noise of the channels of one quantity, rms, such as "2 mg"; repeatable.',
            show_default="5 mg, 0.01 N, 10 nm, 10 um/s",
        ),
    ] = None,
    offset: Annotated[
        list[str] | None,
        typer.Option(
            metavar="VALUE",
            help='Offset of the channels, one standard deviation, such as "20 mg"; repeatable.',
            show_default="none",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of noise and random excitation.", min=0)] = 0,
    growth: Annotated[
        bool, typer.Option(help="Run twice, to tell where the motion is chaotic.")
    ] = True,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace recordings that are there.")
    ] = False,
    out: output.OutOption = None,
    effects: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Write the recordings that a log describes, from a model.

    A campaign can so be rehearsed before the shaker is booked: each test is shaken as the log
    says, passes the recorder's filter, and gets noise of its own. Without --out the recordings
    are written where the log expects them; with it, beside a copy of the log. Nothing that
    is there is replaced without --overwrite.
    """
    from shakerproc.cli.messages import announce
    from shakerproc.model_files import read_model
    from shakerproc.planning import Staging
    from shakerproc.planning.rehearsal import USUAL_NOISE
    from shakerproc.recordings import read_hashed
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.simulation import rehearse_campaign

    is_log = excitation.suffix.lower() in {".yaml", ".yml"}
    if is_log:
        options.check_order(model, excitation)
    announce()
    staging = Staging(
        sample_rate=sample_rate_hz,
        duration=duration_s,
        lead_in=lead_in_s,
        lead_out=lead_out_s,
        noise={**USUAL_NOISE, **_quantities(noise or (), "--noise")},
        offset=_quantities(offset or (), "--offset"),
        seed=seed,
        growth=growth,
    )
    if is_log:
        wanted = [one.strip() for one in tests.split(",") if one.strip()]
        log, driven_by = read_hashed(read_testlog, excitation)
        shaken, model_hash = read_hashed(read_model, model)
        output.say_planned_tests(log)
        with output.progress("simulate", len(wanted or log.active)) as advance:
            recordings = rehearse_campaign(
                shaken, log, staging, folder=out, wanted=wanted, overwrite=overwrite,
                advance=advance, warn=output.warning,
            )  # fmt: skip
    else:
        shaken, model_hash = read_hashed(read_model, model)
        one, driven_by = _respond(shaken, excitation, staging, out, overwrite=overwrite)
        recordings = [one]
    inputs = {model.name: model_hash, excitation.name: driven_by}
    output.write_json(
        {**_document(inputs, seed, recordings), **options.effects_of(effects)}, json
    )
    _print(recordings, shaken.motion)
    place = excitation.parent if out is None else out
    output.message(f"{len(recordings)} recording{'s' * (len(recordings) != 1)} below {place}")


def _quantities(texts: "Sequence[str]", option: str) -> dict[str, float]:
    """Return values by their SI units.

    Raises
    ------
    typer.BadParameter
        If a text is no quantity that a channel measures, or below 0.
    """
    from shakerproc.units import to_si

    values: dict[str, float] = {}
    for text in texts:
        for unit in QUANTITIES:
            try:
                value = to_si(text, unit)
            except ValueError:
                continue
            if value < 0.0:
                raise typer.BadParameter(f"{text} is below 0", param_hint=option)
            values[unit] = value
            break
        else:
            raise typer.BadParameter(
                f'expected a quantity such as "5 mg", "0.1 N" or "1 um", not {text!r}',
                param_hint=option,
            )
    return values


def _respond(
    model: "Model", path: Path, staging: "Staging", out: Path | None, *, overwrite: bool
) -> tuple[dict[str, object], str]:
    """Write the response of the model to a recorded input; return its numbers and a hash.

    Raises
    ------
    LogError
        If the file is there already.
    """
    from shakerproc.errors import LogError
    from shakerproc.planning import respond, with_usual_roles
    from shakerproc.recordings import open_recording
    from shakerproc.workflows.simulation import write_recording

    target = (path.parent if out is None else out) / f"{path.stem}_simulated.tdms"
    if target.exists() and not overwrite:
        raise LogError(f"{target} is there already; give --out FOLDER or --overwrite")
    with open_recording(path, hashed=True) as recording:
        known = with_usual_roles(recording)
        output.tell_faults(known, model.excitation.role, 0.0, known.duration)
        made = respond(model, known, staging)
        digest = recording.sha256()
    write_recording(target, made.recording)
    return {**made.facts, "recording": target.name}, digest


def _document(
    inputs: "Mapping[str, str]", seed: int, recordings: "Sequence[Mapping[str, object]]"
) -> dict[str, object]:
    from shakerproc import __version__

    return {
        "schema": "shakerproc-simulation/1",
        "shakerproc": __version__,
        "inputs": inputs,
        "seed": seed,
        "recordings": recordings,
    }


def _print(recordings: "Sequence[Mapping[str, object]]", motion: "Motion") -> None:
    from shakerproc.models.motion import shown_in

    unit, factor = shown_in("m", motion)
    rows = []
    for one in recordings:
        moved = one["largest_relative_displacement_m"]
        most = max(moved.values()) if isinstance(moved, dict) else None
        rows.append((
            one["test"], one["recording"], one["duration_s"], factor * most if most else None,
            one["switchings"], one["growth"], "chaotic" if one["chaotic"] else None,
        ))  # fmt: skip
    output.print_table(
        ("test", "recording", "takes [s]", f"largest motion [{unit}]", "switchings",
         "growth of 1e-10", "remark"),
        rows)  # fmt: skip
    if any(one["chaotic"] for one in recordings):
        output.warning(
            "chaotic motion: any model of it agrees with these recordings in statistics only"
        )
