"""Whatever is handed over as an argument of the API: one sentence that names it, or none."""

import inspect
from pathlib import Path

import numpy as np
import pytest
from tests.comparison.small_campaigns import campaign, drive, written

import shakerproc as sp
from shakerproc.workflows import campaign as tests_of_a_log
from shakerproc.workflows import (
    comparison,
    diagnosis,
    forecast,
    modes,
    run,
    simulation,
    updated_model,
)
from shakerproc.workflows.processing_options import Options

RECORDING = Path(__file__).parents[2] / "sample_data/recordings/Test_1/Acceleration.tdms"
KINDS = (
    3, -1, 0, 2.5, float("nan"), float("inf"), 10**400, "x", "", True, object(), [], [1],
    ["x"], {}, {"a": "b"}, b"x", np.zeros(3), (1, 2), (2, "x"), {1, 2}, 1j, len,
)  # fmt: skip
WORK = {
    run: "process_file", tests_of_a_log: "_in_threads", comparison: "compare_any",
    modes: "modes_of", diagnosis: "diagnose_tests", updated_model: "fitted_effect",
    simulation: "simulated", forecast: "forecast_log",
}  # fmt: skip
GIVEN = {
    "open_recording": ("path",), "read_log": ("path",), "read_model": ("path",),
    "process": ("recording",), "batch": ("log",), "compare": ("model", "log"),
    "diagnose": ("model", "log"), "add": ("effect", "model", "log"), "modes": ("log",),
    "simulate": ("model", "excitation", "sample_rate"), "effects": (),
    "forecast": ("model", "log"),
}  # fmt: skip


BESIDE = {"override_unit": ("unit",), "to_hz": ("from_hz",), "excitation": ("duration",)}
"""Arguments that are told with another, which they go with."""


class Reached(sp.ShakerprocError):
    """All arguments were taken, and the work would begin."""


def begins(*_args, **_named):
    raise Reached("")


@pytest.fixture(scope="module")
def usable(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    log, model = written(campaign(drives=(drive(level=3.0),), seconds=1.0), folder)
    return {
        "path": RECORDING, "recording": RECORDING, "log": sp.read_log(log),
        "model": sp.read_model(model), "effect": "gap", "excitation": [1.0, 2.0],
        "sample_rate": 1e3,
    }  # fmt: skip


def arguments_of(function):
    named = inspect.signature(function).parameters.values()
    names = [p.name for p in named if p.kind is not p.VAR_KEYWORD]
    return names if len(names) == len(named) else [*names, *Options.__annotations__]


def told(function, **given):
    """Return the error that a call ends with; None where its work begins."""
    try:
        function(**given)
    except Reached:
        return None
    except sp.ShakerprocError as error:
        return error
    return None


@pytest.mark.parametrize("name", sp.API)
def test_an_argument_of_any_kind_is_taken_or_told_by_its_name(
    name, usable, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    for module, work in WORK.items():
        monkeypatch.setattr(module, work, begins)
    function = getattr(sp, name)
    for argument in arguments_of(function):
        for kind in KINDS:
            given = {word: usable[word] for word in GIVEN[name]} | {argument: kind}
            stop = {"figures": "not yet"} if argument == "out" else {}
            error = told(function, **given, **stop)
            assert "\n" not in str(error)
            named = error.name if isinstance(error, sp.ArgumentError) else argument
            assert named in {argument, *stop, *BESIDE.get(argument, ())}, error
    assert not list(tmp_path.iterdir())


def test_results_tell_what_their_methods_do_not_take(usable):
    recording, run_, effects = (
        sp.open_recording(RECORDING), sp.process(RECORDING), sp.effects()
    )  # fmt: skip
    for kind in KINDS:
        for method, argument in (
            (recording.to_pandas, "start_s"), (recording.to_pandas, "stop_s"),
            (run_.plot, "figure"), (effects.plot, "kind"),
        ):  # fmt: skip
            error = told(method, **{argument: kind})
            assert error is None or error.name in {argument, "start_s"}
