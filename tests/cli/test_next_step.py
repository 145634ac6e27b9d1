"""After a command one line says what comes next, with words that can be typed as they stand."""

import shlex
from dataclasses import replace
from pathlib import Path

import pytest
import typer
from tests.diagnosis.test_headline import FOUND

from shakerproc.cli import build_app, messages, output

LOG = Path("my campaign/log.yaml")


def typed(told):
    """Return the command of the line, as a shell parts it."""
    (line,) = told.splitlines()
    assert line.startswith("next: ")
    return shlex.split(line[line.index("shakerproc ") :]) if "shakerproc " in line else []


def test_a_recording_of_a_log_leads_to_its_batch(capsys):
    messages.after_processing(Path("run.tdms"), LOG)
    assert typed(capsys.readouterr().err) == ["shakerproc", "batch", str(LOG)]


def test_a_batch_leads_to_the_model_beside_the_log(tmp_path, capsys):
    log = tmp_path / "log.yaml"
    log.write_text("testlog: 1\n")
    messages.after_batch(log)
    assert "compare MODEL" in capsys.readouterr().err
    (tmp_path / "other.yaml").write_text("# a comment\n\nmodel: 1\n")
    messages.after_batch(log)
    told = typed(capsys.readouterr().err)
    assert told == ["shakerproc", "compare", str(tmp_path / "other.yaml"), str(log)]


@pytest.mark.parametrize("explained", [True, False])
def test_a_comparison_leads_to_the_diagnosis_unless_all_is_explained(explained, capsys):
    messages.after_comparing(Path("m.yaml"), LOG, explained=explained)
    told = capsys.readouterr().err
    if explained:
        assert "nothing to add" in told
    else:
        assert typed(told) == ["shakerproc", "diagnose", "m.yaml", str(LOG)]


def test_a_diagnosis_leads_to_the_effect_that_it_found(capsys):
    messages.after_diagnosis(FOUND, Path("a b/m.yaml"), LOG)
    assert typed(capsys.readouterr().err) == [
        "shakerproc", "add", "gap", "a b/m.yaml", str(LOG), "--between", "base,coupon",
        "-o", "a b/m-with-gap.yaml",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("verdict", "word"),
    [
        ("nothing missing", "nothing to add"),
        ("measurement fault", "repair the sensor"),
        ("outside library", "add table"),
        ("cannot tell", "diagnose"),
    ],
)
def test_every_verdict_leads_somewhere(verdict, word, capsys):
    found = replace(FOUND, verdict=verdict)
    messages.after_diagnosis(found, Path("m.yaml"), LOG)
    assert word in capsys.readouterr().err


def test_nothing_is_said_beside_json_on_stdout(capsys):
    with typer.Context(typer.main.get_command(build_app(["doctor"]))) as context:
        output.checked_json(context, "-")
        messages.after_diagnosis(FOUND, Path("m.yaml"), LOG)
        output.data("text")
        output.print_table(("a",), [(1.0,)])
    assert capsys.readouterr() == ("", "")
    output.data("text")
    assert capsys.readouterr().out == "text\n"
