"""What every test shares: loud floating-point errors and the way to the shared data."""

import gc
import os
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import settings

from tests.within import processes, within  # noqa: F401 - fixtures of every test

mpl.use("Agg")

# pytest imports readline, which tells every process started later that a terminal is 80 wide
for name in ("COLUMNS", "LINES"):
    os.environ.pop(name, None)
    os.unsetenv(name)

# a slow machine is no failure, and the same draws fail everywhere
settings.register_profile("shakerproc", deadline=None, derandomize=True)
settings.load_profile("shakerproc")


def pytest_configure():
    """Collect no garbage while thousands of tests are imported: all of it stays."""
    gc.disable()


def pytest_collection_finish():
    """Leave out of each later collection what was imported."""
    gc.freeze()
    gc.enable()


SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(autouse=True)
def loud_floating_point():
    """Turn overflow, invalid values and division by zero into errors."""
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        yield


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared data and references beside the checkout."""
    if not SHARED.is_dir():
        pytest.skip(f"no shared data: {SHARED} is absent")
    return SHARED


@pytest.fixture
def few_effects(monkeypatch):
    """Let a diagnosis seek five effects only, where its verdict is not the subject."""
    from tests.few_effects import seek_few

    seek_few(monkeypatch)


@pytest.fixture
def fitted_once(monkeypatch):
    """Have an effect fitted once that is added to one model again and again."""
    from shakerproc.diagnosis import adding

    fit, known = adding.fitted_effect, []

    def fitted(model, tests, wanted, say):
        for one, kind, found in known:
            if (one, kind) == (model, wanted.kind):
                return found
        known.append((model, wanted.kind, fit(model, tests, wanted, say)))
        return known[-1][-1]

    monkeypatch.setattr(adding, "fitted_effect", fitted)
