"""``shakerproc study``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from shakerproc.studies import StudyResult
    from shakerproc.workflows.arguments import Machines


def study(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="STUDY", help="Study files (YAML).", show_default=False, exists=True
        ),
    ] = None,
    thesis: Annotated[
        bool,
        typer.Option(
            "--thesis", help="Check the statements of the thesis, and print the table."
        ),
    ] = False,
    resume: Annotated[bool, typer.Option(help="Reuse the results of an earlier run.")] = True,
    workers: Annotated[
        int | None, typer.Option(help="Runs side by side.", min=1, show_default="cores")
    ] = None,
    scheduler: options.SchedulerOption = None,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Run parameter studies: tables and figures.

    Figures are of the peak frequency, bifurcations, maps and curves. The peak frequency is
    always given with its estimator, the width of its bins, the direction of the sweep and, with
    free play, F / (k a), which alone decides the shape of the response.
    """
    from shakerproc.cli.messages import announce

    announce()
    if thesis == bool(files):
        raise typer.BadParameter("name study files, or give --thesis", param_hint="STUDY")
    if thesis:
        if scheduler is not None:
            raise typer.BadParameter(
                "the statements of the thesis are checked on this machine",
                param_hint="--scheduler",
            )
        _thesis(out, json)
        return
    from shakerproc.workflows.arguments import LONG, MUCH, Machines

    documents = []
    for path in files or []:
        machines = Machines(workers, LONG, MUCH, scheduler)
        result, digest = _run(path, out, machines, resume=resume, figures=figures)
        documents.append(_document(path, digest, result))
        _print(result)
    output.write_json(
        {"schema": "shakerproc-studies/1", "studies": documents} if documents else None, json
    )


def _folder(out: Path | None, path: Path) -> Path:
    return output.out_folder(None if out is None else out / path.stem, f"{path.stem}_study")


def _run(
    path: Path, out: Path | None, machines: "Machines", *, resume: bool, figures: bool
) -> "tuple[StudyResult, str]":
    import os

    from shakerproc import files
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.recordings import read_hashed
    from shakerproc.studies import read_study, run_study
    from shakerproc.studies.kinds.base import jobs_of

    read, digest = read_hashed(read_study, path)
    for note in () if read.claim is None else read.claim.notes:
        output.message(f"note: {note}")
    total = len(jobs_of(read))
    folder = _folder(out, path)
    check_result_folder(folder, "study")
    with output.progress(read.title, total) as advance:
        result = run_study(
            read,
            folder=folder / "points" if resume and total > 1 else None,
            workers=machines.workers or os.cpu_count() or 1,
            executor=None if machines.scheduler is None else machines.executor(),
            progress=advance,
        )
    with output.results(folder, "study"):
        files.write_csv(folder / "table.csv", result.columns)
        if figures:
            from shakerproc.report.figures import style
            from shakerproc.report.figures.to_png import save
            from shakerproc.report.models.curves import study_figure

            with style.look():
                save(study_figure(result), folder / "figure.png")
    output.message(f"results in {folder}")
    return result, digest


def _document(path: Path, digest: str, result: "StudyResult") -> dict[str, object]:
    from shakerproc import __version__

    return {
        "version": __version__,
        "study": path.name,
        "study_sha256": digest,
        "title": result.title,
        "figure": result.figure,
        "method": result.method,
        "statement": result.statement,
        "verdict": result.outcome,
        "checks": result.checks,
        "comment": result.comment,
        "quantities": result.quantities,
        "notes": result.notes,
        "table": result.columns,
    }


MOST_ROWS = 60
"""Longer tables are only in the file."""


def _print(result: "StudyResult") -> None:
    named = f"{result.title} (figure {result.figure})" if result.figure else result.title
    output.data(named)
    rows = list(zip(*(c.tolist() for c in result.columns.values()), strict=True))
    if len(rows) <= MOST_ROWS:
        output.print_table(list(result.columns), rows)
    else:
        output.data(f"{len(rows)} rows in table.csv")
    output.data(result.method)
    for note in result.notes:
        output.data(f"note: {note}")
    if result.statement:
        output.data(f"stated: {result.statement}")
    output.data(f"found: {result.verdict}")
    if result.comment:
        output.data(f"comment: {result.comment}")


def _thesis(out: Path | None, json: str | None) -> None:
    from shakerproc import files
    from shakerproc.verification import claims_page, thesis_claims

    with output.progress("statements of the thesis", len(thesis_claims())) as advance:
        outcomes = []
        for claim in thesis_claims():
            outcomes.append(claim.outcome())
            advance(claim.where)
    output.write_json({"schema": "shakerproc-thesis-claims/1", "claims": outcomes}, json)
    output.print_table(
        ("where", "thesis", "our number", "checked", "held"),
        [(o.where, o.says, o.number, "; ".join(map(str, o.checks)), o.held) for o in outcomes],
    )
    if out is not None:
        path = output.out_folder(out, "") / "thesis_claims.md"
        files.write_text(path, claims_page(outcomes))
        output.message(f"table in {path}")
