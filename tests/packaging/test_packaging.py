"""What a wheel holds and asks for; `make oldest` builds one and runs the quick tests on it."""

import importlib.metadata
import re
import tomllib
from pathlib import Path

import pytest
from tests import oldest

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src" / "shakerproc"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_oldest_versions_are_the_lower_bounds_of_all_that_a_run_needs():
    wanted = PROJECT["project"]["dependencies"]
    optional = PROJECT["project"]["optional-dependencies"]["cluster"]
    assert oldest.pins() == [one.replace(">=", "==") for one in [*wanted, *optional]]


def test_what_is_installed_here_is_not_older_than_the_lower_bounds():
    def release(text):
        return [int(part) for part in re.match(r"[\d.]+", text)[0].strip(".").split(".")]

    for pin in oldest.pins():
        name, lowest = pin.split("==")
        assert release(importlib.metadata.version(name)) >= release(lowest), name


@pytest.mark.parametrize("requirement", ["numpy", "numpy>2.0", "numpy>=2.0,<3", "numpy==2.0"])
def test_a_dependency_without_a_plain_lower_bound_is_told(requirement):
    with pytest.raises(ValueError, match=f"{requirement}.*has no plain lower bound"):
        oldest.lowest([requirement])


def test_every_file_that_is_no_module_is_packed_into_the_wheel():
    patterns = PROJECT["tool"]["setuptools"]["package-data"]["shakerproc"]
    packed = {path for pattern in patterns for path in SOURCES.glob(pattern)}
    files = {
        path
        for path in SOURCES.rglob("*")
        if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts
    }
    assert files - packed == set()
    assert any(path.suffix == ".j2" for path in files)
