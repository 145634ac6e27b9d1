"""The page of conformance holds what the generator prints, and every check on it passes."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def generator():
    spec = importlib.util.spec_from_file_location(
        "make_conformance", DOCS / "make_conformance.py"
    )
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def every(generator):
    return [check for made in generator.checks().values() for check in made]


def test_every_number_of_a_standard_is_found(every):
    assert [check for check in every if not check.passed] == []
    assert len(every) >= 100


def test_the_standards_that_are_named_are_there(every):
    found = {check.standard for check in every}
    for name in ("18431-4", "61260-1", "E1049", "7626", "16063", "1683", "2041", "MIL-STD-810"):
        assert any(name in standard for standard in found), name


def test_no_check_passes_whatever_is_found(every):
    """A tenth more is beyond the tolerance of every number but the limits of a mask."""
    for check in every:
        if isinstance(check.wanted, float) and check.wanted:
            assert not replace(check, found=1.1 * check.wanted).passed, check
        elif isinstance(check.wanted, str):
            assert not replace(check, found="another name").passed
        elif isinstance(check.wanted, tuple):
            assert not replace(check, found=check.wanted[0] - 0.01).passed


def test_the_page_is_current(generator):
    assert (DOCS / "conformance.md").read_text(encoding="utf-8") == generator.page()
