"""``shakerproc modal``."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from shakerproc.cli import options, output

TestOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--test", metavar="ID", help="This test only; may be repeated."),
]
AgainstOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="TESTLOG",
        help="A second log: its modes beside these.",
        exists=True,
        dir_okay=False,
    ),
]
FromOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        help="Lowest frequency [Hz].", show_default="the log's", callback=options.positive
    ),
]
ToOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        help="Highest frequency [Hz].", show_default="the log's", callback=options.positive
    ),
]
CountOption: TypeAlias = Annotated[
    int | None,
    typer.Option(help="How many modes.", min=1, max=200, show_default="as many as are needed"),
]
OrderOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        help="Highest order of the stabilisation diagram.",
        min=4,
        max=400,
        show_default="the log's, else 60",
    ),
]
TogetherOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--together",
        help="One fit of all tests: the same modes, forces at several places.",
        show_default="the log's",
    ),
]


def modal(
    log: options.LogOrFunctions,
    test: TestOption = None,
    against: AgainstOption = None,
    from_hz: FromOption = None,
    to_hz: ToOption = None,
    count: CountOption = None,
    order: OrderOption = None,
    together: TogetherOption = False,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Find natural frequencies, damping and mode shapes of tests.

    Inputs are the controls, else the force channels; where there are none, output only. Modes
    are chosen automatically and followed from test to test. Response functions that an analyser
    has exported are taken as they are, without a log.
    """
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.cli.batch_output import print_analysis, write_folder
    from shakerproc.recordings.response_functions import holds_functions
    from shakerproc.testlog import Modal, read_testlog
    from shakerproc.workflows.modes import modes_of, modes_of_functions, wish_of

    folder = Path(f"{log.stem}_modal") if out is None else out
    if holds_functions(log):
        if test or against is not None or together:
            raise typer.BadParameter(
                "--test, --against and --together are for test logs, not for response functions"
            )
        check_result_folder(folder, "modal")
        wish = wish_of(Modal(), band=_band(from_hz, to_hz), count=count, order=order)
        measured = modes_of_functions(log, wish)
        output.write_json(measured.as_json(), json)
        print_analysis(measured.found)
        write_folder(folder, measured.found, measured.as_json(), [log], figures=figures)
        output.message(f"results in {folder}")
        return
    read = read_testlog(log)
    output.say_planned_tests(read)
    wish = wish_of(read.modal, band=_band(from_hz, to_hz), count=count, order=order)
    wish = replace(wish, together=wish.together or together)
    tests = [read.find(name) for name in test] if test else read.active
    other = None if against is None else read_testlog(against)
    check_result_folder(folder, "modal")
    total = len(tests) + (0 if other is None else len(other.active))
    with output.progress("modes", total) as advance:
        modes = modes_of(read, tests, wish, other, advance)
    analysis, document = modes.found, modes.as_json()
    output.write_json(document, json)
    print_analysis(analysis)
    logs = [log, *([against] if against else [])]
    write_folder(folder, analysis, document, logs, figures=figures)
    output.message(f"results in {folder}")
    if analysis.failed:
        output.finish(1)


def _band(from_hz: float | None, to_hz: float | None) -> tuple[float, float] | None:
    """Return the band that the options say, None where they do not.

    Raises
    ------
    typer.BadParameter
        If only one end of the band is given, or it is empty.
    """
    if from_hz is None and to_hz is None:
        return None
    if from_hz is None or to_hz is None:
        raise typer.BadParameter("give --from-hz and --to-hz, or neither", param_hint="--to-hz")
    if from_hz >= to_hz:
        raise typer.BadParameter("must be above --from-hz", param_hint="--to-hz")
    return from_hz, to_hz
