"""The manual: it builds strictly, needs nothing from elsewhere, and its commands run."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.docs import console
from tests.docs.fixtures import write_recordings

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md") if "```console" in p.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_every_command_of_a_page_prints_what_the_page_shows(page, tmp_path):
    for name in ("sample_data", "configs", "examples", "docs"):
        (tmp_path / name).symlink_to(ROOT / name)
    write_recordings(tmp_path)
    wrong = console.play(page, tmp_path)
    assert not wrong, "\n\n".join(wrong)


def test_the_comparison_of_outputs_finds_what_differs():
    assert console.disagreement(("a 1.00", "...", "b"), "a 1.04\nx\ny\nb\n") is None
    assert console.disagreement(("a 1.00",), "a 1.06\n") == "a 1.00"
    assert console.disagreement(("a", "b"), "a\nx\nb\n") == "b"
    assert "nothing more" in console.disagreement(("a",), "a\nb\n")
    assert console.disagreement(("gap 1",), "stop 1\n") == "gap 1"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocs", reason="the extra docs is not installed")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_the_manual_fetches_nothing_from_elsewhere(site):
    wanted = re.compile(
        r"""<(?:script|link|img|iframe|source)[^>]*(?:src|href)=["'](?:https?:)?//[^"']*"""
        r"""|url\(\s*["']?(?:https?:)?//|@import"""
    )
    for path in [*site.rglob("*.html"), *site.rglob("*.css")]:
        found = wanted.search(path.read_text(encoding="utf-8"))
        assert found is None, f"{path.relative_to(site)}: {found[0]}"


@pytest.mark.slow
def test_there_is_a_page_with_a_picture_for_each_effect_and_fault(site):
    from shakerproc.models import EFFECTS, FAULTS

    for kind in (*EFFECTS, *FAULTS):
        page = (site / "effects" / f"{kind}.html").read_text(encoding="utf-8")
        assert f'src="{kind}.svg"' in page
        assert (site / "effects" / f"{kind}.svg").is_file()
        for heading in ("In the data", "What it is confused with", "In a model file"):
            assert heading in page
        if kind in EFFECTS:
            assert "<math" in page
            assert "\\" not in re.search("<math.*?</math>", page, re.DOTALL)[0]


def test_no_console_block_is_left_out():
    """A command line outside of a console block is checked by tests/cli/test_frame.py only."""
    assert {page.stem for page in PAGES} >= {"tutorial"}
    assert shutil.which(sys.executable)
