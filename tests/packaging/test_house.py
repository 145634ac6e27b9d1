"""How the code is built: what `python -m benchmarks.house` counts stays within its limits."""

from pathlib import Path

import pytest
from benchmarks.house import house, parsed

SOURCE = Path(__file__).parents[2] / "src" / "shakerproc"

pytestmark = pytest.mark.slow  # reads every file of the program


@pytest.fixture(scope="module")
def functions():
    yield house(SOURCE)[1]
    parsed.cache_clear()  # some millions of objects


def test_no_function_has_more_than_60_lines_of_code(functions):
    long = {f.where: f.lines for f in functions if f.kind == "plain" and f.lines > 60}
    long |= {f.where: f.body for f in functions if f.kind == "command" and f.body > 60}
    assert not long


def test_no_file_of_the_diagnosis_has_more_than_300_lines():
    files = (SOURCE / "diagnosis").rglob("*.py")
    lines = {file.name: len(file.read_text("utf-8").splitlines()) for file in files}
    assert not {name: count for name, count in lines.items() if count > 300}


def test_no_function_has_more_than_eight_parameters(functions):
    assert [f.where for f in functions if f.kind == "plain" and f.parameters > 8] == []


def test_nine_of_ten_public_functions_say_the_units_of_what_they_take(functions):
    taking = [f for f in functions if f.kind == "plain" and f.public and f.quantities]
    assert sum(f.with_units for f in taking) >= 0.9 * len(taking)
    public = [f for f in functions if f.kind == "plain" and f.public]
    assert [f.where for f in public if not f.documented] == []
