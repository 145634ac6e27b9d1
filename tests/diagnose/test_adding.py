"""`add` writes no model that is worse, and fits keep the bounds of their effects."""

import numpy as np
import pytest
import yaml
from tests.compare.small_campaigns import campaign, written
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.diagnose.candidates import BOUC_WEN
from shakerproc.diagnose.fit import Code
from shakerproc.diagnose.problem import Hypothesis, Parameters, Term
from shakerproc.models import EFFECTS


@pytest.fixture(scope="module")
def linear(tmp_path_factory):
    """A campaign in which nothing is missing."""
    path = tmp_path_factory.mktemp("linear")
    written(campaign(seconds=2.0, noise=0.02, hold_out=(1,)), path)
    return path


def add(place, kind, *more):
    arguments = ["add", kind, place / "model.yaml", place / "testlog.yaml", *more]
    return CliRunner().invoke(build_app(), [str(a) for a in arguments])


@pytest.mark.parametrize("kind", ["gap", "cubic_stiffness"])
def test_an_effect_that_is_not_there_is_not_written(linear, kind, tmp_path):
    result = add(linear, kind, "-o", tmp_path / "new.yaml")
    assert result.exit_code == 1
    text = str(result.exception)
    assert text.startswith(f"{kind} between base and coupon: the held-out error ")
    assert text.endswith("No model is written; --force writes it all the same.")
    assert list(tmp_path.iterdir()) == []


def test_it_is_written_by_force_which_says_so(linear, tmp_path):
    result = add(linear, "cubic_stiffness", "-o", tmp_path / "new.yaml", "--force")
    assert result.exit_code == 0
    assert "written although the held-out error" in " ".join(result.stderr.split())
    assert (tmp_path / "new.yaml").is_file()


def test_every_test_held_out_is_said_at_once(linear, tmp_path):
    log = linear / "all_held_out.yaml"
    document = yaml.safe_load((linear / "testlog.yaml").read_text())
    for test in document["tests"]:
        test["hold_out"] = True
    log.write_text(yaml.safe_dump(document))
    arguments = ["add", "gap", linear / "model.yaml", log, "-o", tmp_path / "new.yaml"]
    result = CliRunner().invoke(build_app(), [str(a) for a in arguments])
    assert result.exit_code == 1
    assert "every test is held out" in str(result.exception)


def test_a_fit_never_leaves_what_the_effect_allows():
    start = Parameters(
        np.array([1e4]), np.array([1.0]), np.ones(1), np.zeros(1), ((1e4, 1e-4, 1.5),)
    )
    code = Code(Hypothesis((Term(BOUC_WEN, 0),)), start, np.array([1.0]))
    low = np.full(code.pack(start).size, -50.0)
    values = code.unpack(low).values[0]
    EFFECTS["bouc_wen"](*values)
    assert values[2] == 1.0
