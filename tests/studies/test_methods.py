"""The thesis' methods in studies: they approach the exact motion, each at its own pace."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shakerproc.errors import DocumentError
from shakerproc.studies import read_study
from shakerproc.studies.readings import simulated
from shakerproc.studies.study import StudyRun

STUDIES = Path(__file__).parents[2] / "configs" / "studies"
RUN = StudyRun(
    "sine sweep", level=5.0, from_hz=0.0, to_hz=10.0, duration=2.0, sample_rate=500.0
)


@pytest.fixture(scope="module")
def model():
    return read_study(STUDIES / "gap_random.yaml").model


def error(model, run, every=1):
    exact = simulated(model, replace(run, method="exact"), growth=False).displacement
    found = simulated(model, run).displacement
    return np.max(np.abs(found - exact)[::every]) / np.max(np.abs(exact))


def test_newmark_falls_with_the_square_of_its_step(model):
    coarse = error(model, replace(RUN, method="Newmark"))
    fine = error(model, replace(RUN, method="Newmark", sample_rate=2000.0))
    assert 8.0 < coarse / fine < 40.0
    assert fine < 1e-2


@pytest.mark.parametrize("method", ["RK45", "BDF"])
def test_a_solver_of_matlabs_kind_falls_with_its_tolerance(model, method):
    loose = error(model, replace(RUN, method=method))
    tight = error(model, replace(RUN, method=method, tolerance=1e-7))
    assert tight < 1e-3 < loose


def test_a_base_that_moves_gives_absolute_acceleration():
    shaken = read_study(STUDIES / "temperature.yaml").model
    run = StudyRun("sine", level=5.0, frequency=50.0, duration=0.2, sample_rate=20_000.0)
    exact = simulated(shaken, run, growth=False).acceleration
    found = simulated(shaken, replace(run, method="Newmark")).acceleration
    assert np.max(np.abs(found - exact)) < 1e-2 * np.max(np.abs(exact))


def test_random_excitation_is_drawn_alike_for_every_method(model):
    run = StudyRun(
        "random", level=2.0, from_hz=1.0, to_hz=10.0, duration=1.0, sample_rate=1000.0
    )
    assert error(model, replace(run, method="RK45", tolerance=1e-8)) < 1e-2


def test_an_unknown_method_is_told_with_its_place(tmp_path):
    (tmp_path / "models").mkdir()
    text = (STUDIES / "models" / "gap.yaml").read_text()
    (tmp_path / "models" / "gap.yaml").write_text(text)
    study = (STUDIES / "newmark_steps.yaml").read_text().replace("Newmark}", "Euler}")
    (tmp_path / "s.yaml").write_text(study)
    with pytest.raises(DocumentError, match=r"s\.yaml:6:.*method"):
        read_study(tmp_path / "s.yaml")
