"""The antenna of the examples: 62 Hz glued, 56 Hz while the clearance of foot 2 is open."""

import importlib.util
from pathlib import Path

import pytest

from shakerproc.comparison.modes import natural_modes
from shakerproc.model_files import read_model

SCRIPT = Path(__file__).parents[2] / "examples" / "antenna" / "make_antenna.py"


def test_the_antenna_resonates_at_62_hz_glued_and_at_56_hz_loose(tmp_path):
    spec = importlib.util.spec_from_file_location("make_antenna", SCRIPT)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.write(tmp_path)
    for name, frequency in (("model.yaml", 62.0), ("truth.yaml", 56.0)):
        model = read_model(tmp_path / name)
        found = natural_modes(model, ["tip"]).frequency[0]
        assert found == pytest.approx(frequency, abs=0.5)  # it is told in whole Hz
    structure = model.structures["antenna"]
    assert sum(structure.participations**2) == pytest.approx(example.PLATE.mass, rel=1e-4)
