import os
import sys

import pytest

from shakerproc.errors import PrintingError
from shakerproc.report.page import page as report_page


@pytest.fixture
def page(tmp_path):
    path = tmp_path / "report.html"
    path.write_text("<p>report</p>")
    return path


def browser(path, script):
    """A program that stands for a browser."""
    path.write_text(f"#!{sys.executable}\nimport sys\n{script}\n")
    path.chmod(0o755)
    return path


needs_scripts = pytest.mark.skipif(os.name == "nt", reason="scripts are no programs here")


def test_without_a_browser_one_line_says_what_to_do(page, monkeypatch, tmp_path):
    monkeypatch.delenv(report_page.BROWSER_VARIABLE, raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(report_page, "_usual_places", lambda: iter(()))
    with pytest.raises(
        PrintingError, match=r"none is found.*open .*report\.html in any"
    ) as told:
        report_page.print_report(page, tmp_path / "report.pdf")
    assert "\n" not in str(told.value)


def test_a_browser_that_is_named_and_not_there_is_told(page, monkeypatch, tmp_path):
    monkeypatch.setenv(report_page.BROWSER_VARIABLE, "netscape")
    with pytest.raises(PrintingError, match="names 'netscape', which is not there"):
        report_page.print_report(page, tmp_path / "report.pdf")


@needs_scripts
def test_a_browser_that_prints_nothing_leaves_nothing(page, monkeypatch, tmp_path):
    made = browser(tmp_path / "chrome", "print('no display', file=sys.stderr); sys.exit(3)")
    monkeypatch.setenv(report_page.BROWSER_VARIABLE, str(made))
    with pytest.raises(PrintingError, match=r"printed nothing \(no display\)"):
        report_page.print_report(page, tmp_path / "report.pdf")
    assert {path.name for path in tmp_path.iterdir()} == {"chrome", "report.html"}


@needs_scripts
def test_a_browser_is_given_the_page_and_no_network(page, monkeypatch, tmp_path):
    script = """
import pathlib
target = next(a.partition("=")[2] for a in sys.argv if a.startswith("--print-to-pdf="))
pathlib.Path(target).write_text("\\n".join(sys.argv[1:]))
"""
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.delenv(report_page.BROWSER_VARIABLE, raising=False)
    browser(tmp_path / "chromium", script)
    words = report_page.print_report(page, tmp_path / "report.pdf").read_text().splitlines()
    assert words[-1] == page.as_uri()
    assert "--disable-background-networking" in words
