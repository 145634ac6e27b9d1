"""``shakerproc response``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from shakerproc.models import Model
    from shakerproc.simulation.harmonic_balance import Backbone, Branch, Response

LOWEST_HZ, HIGHEST_HZ = 1e-9, 1e12
"""What a band may reach to [Hz]."""

MOST_ORDER = 16
"""Highest order of a subharmonic that is sought."""


def response(
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="Model (YAML).", exists=True, dir_okay=False)
    ],
    level: Annotated[
        str, typer.Option(metavar="LEVEL", help='Amplitude, such as "0.5 g" or "5 N".')
    ],
    from_hz: Annotated[
        float | None,
        typer.Option(
            help="Lowest frequency [Hz].",
            show_default="0.3 resonances",
            callback=options.positive,
        ),
    ] = None,
    to_hz: Annotated[
        float | None,
        typer.Option(
            help="Highest frequency [Hz].",
            show_default="1.5 resonances",
            callback=options.positive,
        ),
    ] = None,
    harmonics: Annotated[int, typer.Option(help="Highest harmonic.", min=1, max=500)] = 31,
    branches: Annotated[
        bool,
        typer.Option(
            "--branches", help="Follow branches of asymmetric motion and of doubled period."
        ),
    ] = False,
    subharmonic: Annotated[
        list[int] | None,
        typer.Option(metavar="ORDER", help="Seek subharmonics of this order; may be repeated."),
    ] = None,
    backbone: Annotated[bool, typer.Option(help="Follow the free motion too.")] = True,
    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What the figure and the summary show.",
            show_default="the first",
        ),
    ] = None,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    effects: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Compute the frequency response of a model, all branches.

    Periodic motions are found by harmonic balance and followed around the folds; where a
    branch is unstable the motion jumps to another. Where the masses have free play, F / (k a)
    tells how strong the nonlinearity is.
    """
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.cli.messages import announce
    from shakerproc.simulation import harmonic_balance as hb

    if any(not 2 <= order <= MOST_ORDER for order in subharmonic or []):
        raise typer.BadParameter(
            f"an order is from 2 to {MOST_ORDER}, not {', '.join(map(str, subharmonic or []))}",
            param_hint="--subharmonic",
        )
    announce()
    check_result_folder(Path(f"{model.stem}_response") if out is None else out, "response")
    shaken, digest = _read(model)
    amplitude = _level(shaken, level)
    result = _sharp(_response(shaken, amplitude, from_hz, to_hz, harmonics))
    _check_sensor(shaken, sensor)
    others = []
    if branches:
        others = [b for main in result.branches for b in hb.branches_off(main, result.band)]
    for order in subharmonic or []:
        others += hb.subharmonic_branches(result, order, harmonics=min(harmonics, 31))
    others = [hb.sharpened(branch) for branch in others]
    free = _backbone(result, harmonics) if backbone else None
    folder = output.out_folder(out, f"{model.stem}_response")
    with output.results(folder, "response"):
        _write(
            result, tuple(others), free, folder, sensor if figures else None, figures=figures
        )
    document = _document(result, tuple(others), free)
    output.write_json(
        {**_provenance(model, digest, level), **options.effects_of(effects), **document}, json
    )
    _print(result, tuple(others), level, sensor)
    output.message(f"results in {folder}")


def _read(path: Path) -> "tuple[Model, str]":
    from shakerproc.model_files import read_model
    from shakerproc.models.validation import check_unscaled
    from shakerproc.recordings import read_hashed

    model, digest = read_hashed(read_model, path)
    check_unscaled(model, "response")
    return model, digest


def _level(model: "Model", text: str) -> float:
    """Return the amplitude in SI.

    Raises
    ------
    typer.BadParameter
        If it is no acceleration or force above 0.
    """
    from shakerproc.units import to_si

    unit = model.drive_unit
    with options.refused("--level"):
        amplitude = to_si(text, unit)
    if not amplitude > 0.0:
        raise typer.BadParameter(f"must be above 0 {unit}, not {text}", param_hint="--level")
    return amplitude


def _check_sensor(model: "Model", name: str | None) -> None:
    """Pass a sensor that the model has.

    Raises
    ------
    typer.BadParameter
        If it has none of that name.
    """
    from shakerproc.simulation.harmonic_balance import sensors_of_model

    known = sensors_of_model(model)
    if name is not None and name not in known:
        raise typer.BadParameter(
            f"no sensor {name!r}; the model has {', '.join(known)}", param_hint="--sensor"
        )


def _response(
    model: "Model", level: float, from_hz: float | None, to_hz: float | None, harmonics: int
) -> "Response":
    """Return the response over the band.

    Raises
    ------
    typer.BadParameter
        If the band is empty.
    """
    import numpy as np

    from shakerproc.simulation.harmonic_balance import frequency_response, natural_frequencies
    from shakerproc.simulation.harmonic_balance.system import system_of_model

    resonances = natural_frequencies(system_of_model(model, level))
    if not np.any(resonances > 0.0) and (from_hz is None or to_hz is None):
        raise typer.BadParameter(
            f"{model.title}: no spring holds a mass, so that there is no resonance to choose a "
            f"band by; give --from-hz and --to-hz",
            param_hint="MODEL",
        )
    low = 0.3 * resonances[resonances > 0.0][0] if from_hz is None else from_hz
    high = 1.5 * resonances[-1] if to_hz is None else to_hz
    if not 0.0 < low < high:
        raise typer.BadParameter(
            f"must be above 0 Hz and below --to-hz {high:g} Hz, not {low:g} Hz",
            param_hint="--from-hz",
        )
    if not LOWEST_HZ <= low < high <= HIGHEST_HZ:
        raise typer.BadParameter(
            f"a band from {low:g} to {high:g} Hz is beyond {LOWEST_HZ:g} to {HIGHEST_HZ:g} Hz",
            param_hint="--from-hz, --to-hz",
        )
    return frequency_response(
        model, level, from_hz=float(low), to_hz=float(high), harmonics=harmonics
    )


def _sharp(result: "Response") -> "Response":
    from dataclasses import replace

    from shakerproc.simulation.harmonic_balance import sharpened

    return replace(result, branches=tuple(sharpened(branch) for branch in result.branches))


def _backbone(result: "Response", harmonics: int) -> "Backbone | None":
    """Return the backbone up to the largest motion; None, with a warning, if there is none."""
    import numpy as np

    from shakerproc.errors import SimulationError
    from shakerproc.simulation.harmonic_balance import backbone
    from shakerproc.simulation.harmonic_balance.branch import is_linear

    if is_linear(result.branches[0].balance.system):
        output.message("linear: the frequency of free motion does not depend on its amplitude")
        return None
    largest = max(
        float(np.max(np.sum(np.abs(b.coefficients), axis=-1))) for b in result.branches
    )
    try:
        return backbone(result.model, (1e-3 * largest, 1.2 * largest), harmonics=harmonics)
    except SimulationError as error:
        output.warning(str(error))
        return None


def _write(
    result: "Response",
    others: "tuple[Branch, ...]",
    free: "Backbone | None",
    folder: Path,
    sensor: str | None,
    *,
    figures: bool,
) -> None:
    from shakerproc import files
    from shakerproc.simulation.harmonic_balance import response_columns

    files.write_csv(folder / "response.csv", response_columns(result, others))
    if free is not None:
        files.write_csv(
            folder / "backbone.csv",
            {
                "frequency_hz": free.frequency,
                "amplitude_m": free.amplitude,
                "damping_ratio": free.damping_ratio,
            },
        )
    if figures:
        from shakerproc.report.figures import style
        from shakerproc.report.figures.to_png import save
        from shakerproc.report.models.curves import response_figure

        with style.look():
            save(response_figure(result, others, free, sensor), folder / "response.png")


def _provenance(path: Path, digest: str, level: str) -> dict[str, object]:
    from shakerproc import __version__

    return {
        "schema": "shakerproc-response/1",
        "version": __version__,
        "model": path.name,
        "model_sha256": digest,
        "level": level,
    }


def _document(
    result: "Response", others: "tuple[Branch, ...]", free: "Backbone | None"
) -> dict[str, object]:
    from shakerproc.simulation.harmonic_balance import gap_severity, response_columns

    return {
        "title": result.model.title,
        "band_hz": result.band,
        "harmonics": int(result.branches[0].balance.harmonics[-1]),
        "force_over_gap_closing_force": gap_severity(result.model, result.level),
        "branches": [
            {
                "order": branch.balance.order,
                "points": int(branch.frequency.size),
                "ended": branch.ended,
                "marks": branch.marks,
            }
            for branch in (*result.branches, *others)
        ],
        "not_followed": result.not_followed,
        "points": response_columns(result, others),
        "backbone": None
        if free is None
        else {
            "frequency_hz": free.frequency,
            "amplitude_m": free.amplitude,
            "damping_ratio": free.damping_ratio,
        },
    }


def _print(
    result: "Response", others: "tuple[Branch, ...]", level: str, sensor: str | None
) -> None:
    from shakerproc.simulation import harmonic_balance as hb

    sensors = hb.sensors_of_model(result.model)
    name = sensor or next(iter(sensors))
    unit = result.model.sensor_unit(sensors[name])
    output.data(
        f"{result.model.title}: {level}, {numeral(result.band[0], 4)} to "
        f"{numeral(result.band[1], 4)} Hz"
    )
    for joint, severity in hb.gap_severity(result.model, result.level).items():
        output.data(f"{joint}: F / (k a) = {numeral(severity, 4)}")
    output.print_table(
        (
            "branch",
            "period",
            "what",
            "frequency [Hz]",
            f"{name} peak [{unit}]",
            "motion",
            "largest multiplier",
        ),
        [
            (
                point.branch,
                point.order,
                point.what,
                point.frequency_hz,
                point.peak,
                "stable" if point.stable else "unstable",
                point.largest_multiplier,
            )
            for point in hb.notable_points(result, name, others)
        ],
    )
    for number, branch in enumerate((*result.branches, *others), start=1):
        output.data(f"branch {number}: {branch.ended}")
    for sentence in result.not_followed:
        output.data(f"not followed: {sentence}")
