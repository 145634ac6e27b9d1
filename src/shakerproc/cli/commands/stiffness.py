"""``shakerproc stiffness``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from shakerproc.exchange.tensile import JointStiffness, TensileRun

SCHEMA = "shakerproc-stiffness/1"
ALIKE = (
    "the specimens cannot be told apart by their stiffness. The runs may have measured the "
    "grips and the jig, and not the joints (thesis, section 5.3.1); measure across the joint"
)
STIFFENING = (
    "{specimen}: the last runs still stiffen: the grips are still setting; pull more runs "
    "before taking a stiffness"
)


def stiffness(
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUNS...",
            help="Tensile runs in order, or folders of them; a folder is a specimen.",
            exists=True,
        ),
    ],
    last: Annotated[int, typer.Option(help="How many of the last runs count.", min=1)] = 3,
    sample: Annotated[int, typer.Option(help="Sample of the secant, from 1.", min=1)] = 200,
    force_n: Annotated[
        float | None,
        typer.Option(
            help="Take the secant at this force instead [N].", show_default="the sample"
        ),
    ] = None,
    from_share: Annotated[
        float, typer.Option(help="Low end of the slope, share of the largest force.")
    ] = 0.2,
    to_share: Annotated[
        float, typer.Option(help="High end of the slope, share of the largest force.")
    ] = 0.8,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Take the stiffness of a joint from tensile runs.

    Runs are CSV or a testing machine's text export. k as in the thesis is the sum of the last
    forces over the sum of the last displacements at one sample, a secant from zero; the slope
    over a range of force excludes the initial slack (the toe) and comes with 95 % bounds from
    the scatter of the last runs.
    """
    if not 0.0 <= from_share < to_share <= 1.0:
        raise typer.BadParameter(
            f"must lie between 0 and --to-share {to_share:g}, not {from_share:g}",
            param_hint="--from-share",
        )
    specimens = _specimens(runs)
    stiffnesses = [
        _of_specimen(pulled, last, sample, force_n, from_share, to_share)
        for pulled in specimens.values()
    ]
    warnings = _warnings(stiffnesses, last)
    document = _document(stiffnesses, list(specimens.values()), warnings, last, sample, force_n)
    output.write_json(document, json)
    _print(stiffnesses, last)
    for text in warnings:
        output.warning(text)
    folder = output.out_folder(out, "stiffness_results")
    with output.results(folder, "stiffness"):
        _write(folder, stiffnesses, list(specimens.values()), document, last, figures=figures)
    output.message(f"results in {folder}")


def _specimens(paths: list[Path]) -> "dict[str, list[TensileRun]]":
    """Return the runs of each specimen in order; a folder is one, in the order of its numbers.

    Raises
    ------
    ExchangeError
        If a folder holds no runs.
    """
    import re

    from shakerproc.errors import ExchangeError
    from shakerproc.exchange.tensile import read_tensile

    files: list[Path] = []
    for path in paths:
        if not path.is_dir():
            files.append(path)
            continue
        inside = [p for p in path.iterdir() if p.suffix.lower() in {".csv", ".txt", ".tra"}]
        if not inside:
            raise ExchangeError(f"{path}: no tensile runs (.csv, .txt or .tra) in this folder")
        files += sorted(inside, key=lambda p: [int(n) for n in re.findall(r"\d+", p.stem)])
    specimens: dict[str, list[TensileRun]] = {}
    for file in files:
        run = read_tensile(file)
        specimens.setdefault(run.specimen, []).append(run)
    return specimens


def _of_specimen(
    pulled: "list[TensileRun]",
    last: int,
    sample: int,
    force_n: float | None,
    from_share: float,
    to_share: float,
) -> "JointStiffness":
    """Return the stiffness of one specimen.

    Raises
    ------
    ExchangeError
        If its runs do not hold what was asked for.
    """
    from shakerproc.errors import ExchangeError
    from shakerproc.exchange.tensile import joint_stiffness

    try:
        return joint_stiffness(
            pulled,
            last=last,
            sample=sample,
            force=force_n,
            low_share=from_share,
            high_share=to_share,
        )
    except ValueError as error:
        raise ExchangeError(str(error)) from error


def _warnings(stiffnesses: "list[JointStiffness]", last: int) -> list[str]:
    from shakerproc.exchange.tensile import indistinguishable

    texts = [
        STIFFENING.format(specimen=one.specimen) for one in stiffnesses if not one.converged
    ]
    if last > 1 and indistinguishable(stiffnesses, last=last):
        texts.append(ALIKE)
    return texts


def _document(
    stiffnesses: "list[JointStiffness]",
    specimens: "list[list[TensileRun]]",
    warnings: list[str],
    last: int,
    sample: int,
    force_n: float | None,
) -> dict[str, Any]:
    from shakerproc import __version__

    return {
        "schema": SCHEMA,
        "version": __version__,
        "last": last,
        "sample": None if force_n is not None else sample,
        "force_n": force_n,
        "specimens": [
            {
                "specimen": one.specimen,
                "runs": [run.name for run in pulled],
                "k_thesis_n_per_m": one.thesis,
                "k_slope_n_per_m": one.slope,
                "k_secant_of_runs_n_per_m": one.secants,
                "k_slope_of_runs_n_per_m": one.slopes,
                "settled": one.converged,
            }
            for one, pulled in zip(stiffnesses, specimens, strict=True)
        ],
        "warnings": warnings,
    }


def _print(stiffnesses: "list[JointStiffness]", last: int) -> None:
    for one in stiffnesses:
        first = len(one.secants) - last
        rows = [
            (
                number,
                f"{secant / 1e3:.1f}",
                f"{slope.value / 1e3:.1f}",
                f"{slope.low / 1e3:.1f} to {slope.high / 1e3:.1f}",
                "yes" if number > first else "",
            )
            for number, (secant, slope) in enumerate(
                zip(one.secants, one.slopes, strict=True), 1
            )
        ]
        columns = ("run", "secant N/mm", "slope N/mm", "95 %", "counts")
        output.print_table(columns, rows, title=one.specimen)
        mean = one.slope
        output.data(
            f"{one.specimen}: k = {one.thesis / 1e3:.1f} N/mm as in the thesis; slope "
            f"{mean.value / 1e3:.1f} N/mm{_bounds(mean.low, mean.high)} over the last {last} "
            f"runs"
        )


def _bounds(low: float, high: float) -> str:
    return f" ({low / 1e3:.1f} to {high / 1e3:.1f}, 95 %)" if low == low else ""  # noqa: PLR0124


def _write(
    folder: Path,
    stiffnesses: "list[JointStiffness]",
    specimens: "list[list[TensileRun]]",
    document: dict[str, Any],
    last: int,
    *,
    figures: bool,
) -> None:
    from shakerproc import files

    files.write_json(folder / "stiffness.json", document)
    every = [
        (one, run.name, secant, slope)
        for one, pulled in zip(stiffnesses, specimens, strict=True)
        for run, secant, slope in zip(pulled, one.secants, one.slopes, strict=True)
    ]
    files.write_csv(
        folder / "runs.csv",
        {
            "specimen": [one.specimen for one, *_ in every],
            "run": [name for _, name, *_ in every],
            "secant_n_per_m": [secant for *_, secant, _ in every],
            "slope_n_per_m": [slope.value for *_, slope in every],
            "slope_low_n_per_m": [slope.low for *_, slope in every],
            "slope_high_n_per_m": [slope.high for *_, slope in every],
        },
    )
    if figures:
        from shakerproc.report.figures import style
        from shakerproc.report.figures.to_png import save
        from shakerproc.report.models.coupon import all_runs, last_runs

        for number, (one, pulled) in enumerate(zip(stiffnesses, specimens, strict=True), 1):
            end = f"_{number}" if len(stiffnesses) > 1 else ""
            with style.look():
                save(all_runs(pulled, one), folder / f"all_runs{end}.png")
                save(last_runs(pulled, one, last), folder / f"last_runs{end}.png")
