"""What the sentence of a comparison says of levels: in their own unit, of tests of one kind."""

from dataclasses import replace

import pytest
from tests.comparison.small_campaigns import ONE_MASS, campaign, drive, off, written

from shakerproc.comparison import compare, sentence
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog


@pytest.fixture(scope="module")
def forced(tmp_path_factory):
    """Three levels of a force and a model whose stiffness is wrong."""
    structure = replace(ONE_MASS, force_on=0)
    drives = [drive(level=level, number=n) for n, level in enumerate((3.0, 6.0, 9.0), 1)]
    made = campaign(structure, drives=drives, seconds=1.5)
    return written(made, tmp_path_factory.mktemp("forced"), off(structure, stiffness=1.3))


def told(paths, change):
    """Return the sentence with the lines of the log changed."""
    log, model = paths
    lines = [change(line) for line in log.read_text(encoding="utf-8").splitlines()]
    changed = log.with_name("changed.yaml")
    changed.write_text("\n".join(line for line in lines if line), encoding="utf-8")
    return sentence(compare(read_model(model), read_testlog(changed)))


def is_level(line):
    return line.strip(" -").startswith("level:")


def test_levels_that_the_log_does_not_say_are_those_of_the_measured_force(forced):
    said = told(forced, lambda line: "" if is_level(line) else line)
    assert "All tests have one level" not in said
    assert said.count(" N rms)") >= 2


def test_levels_are_compared_in_one_unit_only(forced):
    """Two tests in g and one in N: what the sentence says of levels is of the two in g."""
    levels = iter(["level: 3 g rms", "level: 9 g rms", "level: 37 N rms"])
    said = told(forced, lambda line: f"  {next(levels)}" if is_level(line) else line)
    assert "3 g rms" in said
    assert "(9 g rms)" in said
    assert "N rms" not in said.partition("The error")[2]
