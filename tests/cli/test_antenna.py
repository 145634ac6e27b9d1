"""The antenna of the manual from its finite elements to the joint, by the command line."""

import importlib.util
import json
from pathlib import Path

import pytest
from tests.in_process import completed

SCRIPT = Path(__file__).parents[2] / "examples" / "antenna" / "make_antenna.py"


@pytest.mark.slow
@pytest.mark.long
def test_the_loose_foot_is_named_and_compare_prints_the_error_that_was_promised(tmp_path):
    spec = importlib.util.spec_from_file_location("make_antenna", SCRIPT)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.write(tmp_path)

    def command(*words):
        done = completed(*words, cwd=tmp_path)
        assert done.returncode == 0, done.stderr

    command(
        "simulate", "truth.yaml", "testlog.yaml", "--sample-rate-hz", "2000",
        "--duration-s", "4", "--noise", "1 mg",
    )  # fmt: skip
    command("diagnose", "model.yaml", "testlog.yaml", "--json", "found.json")
    told = json.loads((tmp_path / "found.json").read_text("utf-8"))
    assert told["verdict"] == "effect found", told["sentence"]
    (effect,) = told["effects"]
    assert (effect["kind"], effect["between"]) == ("gap", ["base", "foot 2"])
    clearance = effect["parameters"]["clearance"]["value"]
    assert clearance == pytest.approx(example.CLEARANCE, rel=0.01)
    command(
        "add", "gap", "model.yaml", "testlog.yaml", "--between", "base,foot 2", "-o", "new.yaml"
    )
    command("compare", "new.yaml", "testlog.yaml", "--json", "compared.json")
    after = json.loads((tmp_path / "compared.json").read_text("utf-8"))
    promised = told["errors"]["held_out"]["after"]
    assert after["errors"]["held_out"]["error"] == pytest.approx(promised, rel=0.02)
    assert promised < 0.01 < told["errors"]["held_out"]["before"]
