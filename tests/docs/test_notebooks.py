"""Each notebook under examples runs from top to bottom, and shows what its text promises."""

import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).parents[2] / "examples"
MOMENT = 600
"""Longest that one cell may take, other jobs beside it [s]."""


def executed(name):
    """Return a notebook, run afresh in its folder, and what its cells showed as text."""
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    place = {"metadata": {"path": str(FOLDER)}}
    NotebookClient(notebook, timeout=MOMENT, kernel_name="python3", resources=place).execute()
    return notebook, shown(notebook)


def shown(notebook):
    outputs = [out for cell in notebook.cells for out in cell.get("outputs", [])]
    return "\n".join(
        out.get("text", "") + out.get("data", {}).get("text/html", "") for out in outputs
    )


def pictures(notebook):
    outputs = [out for cell in notebook.cells for out in cell.get("outputs", [])]
    return sum("image/png" in out.get("data", {}) for out in outputs)


def kept(name):
    """Return what the notebook in the repository shows, as it was run when it was written."""
    return shown(nbformat.read(FOLDER / f"{name}.ipynb", as_version=4))


def words(html):
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", html))


def test_every_notebook_is_kept_with_its_outputs_and_has_a_test():
    names = sorted(path.stem for path in FOLDER.glob("*.ipynb"))
    text = Path(__file__).read_text(encoding="utf-8")
    assert len(names) >= 3
    for name in names:
        assert f'executed("{name}")' in text
        assert kept(name)


@pytest.mark.slow
def test_the_first_recording():
    notebook, told = executed("first_recording")
    assert pictures(notebook) == 2
    assert "level: " in told
    assert words(told) == words(kept("first_recording"))


@pytest.mark.slow
@pytest.mark.long
def test_the_campaign():
    notebook, told = executed("campaign")
    assert pictures(notebook) == 2
    assert words(told) == words(kept("campaign"))


@pytest.mark.slow
@pytest.mark.long
def test_the_hidden_gap():
    """Oracle: the play of 0.05 mm that the simulated campaign holds."""
    notebook, told = executed("hidden_gap")
    assert pictures(notebook) == 3
    assert "The model lacks gap between base and coupon" in words(told)
    found = re.search(r"kind: gap.*clearance: ([\d.]+) um", told)
    assert float(found[1]) == pytest.approx(50.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.long
def test_the_antenna():
    """Oracle: the clearance of 0.02 mm that stands in foot 2."""
    notebook, told = executed("antenna")
    assert pictures(notebook) == 2
    assert "The model lacks gap between base and foot 2" in words(told)
    found = re.search(r"<td>clearance</td>\s*<td>([\d.e-]+)</td>", told)
    assert float(found[1]) == pytest.approx(20e-6, rel=0.02)
