"""The published protocols, against figures that others computed without this program."""

from dataclasses import replace

import pytest
from benchmarks.real.protocols import published_errors
from configs.benchmarks import convert

from shakerproc.model_files import read_model
from shakerproc.models import Element
from shakerproc.models.effects import EFFECTS


def model_of(folder, mass, **laws):
    """Return the model of a set with this mass and these laws to the base."""
    model = read_model(folder / "model.yaml")
    (name,) = model.masses
    elements = tuple(
        Element(EFFECTS[kind](**parameters), ("base", name))
        for kind, parameters in laws.items()
    )
    return replace(model, masses={name: mass}, elements=elements)


@pytest.mark.shared
def test_silverbox_linear_and_cubic(shared, tmp_path):
    """Other code left 14.4, 6.59, 6.96 mV, and 0.406, 0.334, 0.335 mV with a cubic spring."""
    folder = convert.folder_of("silverbox", tmp_path, shared / "data")
    linear = {"spring": {"stiffness": 1.01772}, "damper": {"damping": 2.28608e-4}}
    found = published_errors(model_of(folder, 5.33503e-6, **linear), folder)
    assert list(found) == ["multisine", "arrow", "arrow without extrapolation"]
    assert list(found.values()) == pytest.approx([6.96e-3, 14.4e-3, 6.59e-3], rel=0.01)
    cubic = {
        "spring": {"stiffness": 0.990622}, "damper": {"damping": 2.2526e-4},
        "cubic_stiffness": {"coefficient": 3.91516},
    }  # fmt: skip
    found = published_errors(model_of(folder, 5.3759e-6, **cubic), folder)
    assert list(found.values()) == pytest.approx([0.335e-3, 0.406e-3, 0.334e-3], rel=0.06)


@pytest.mark.shared
def test_bouc_wen_linear(shared, tmp_path):
    """A linear oscillator fitted by least squares: 1.74e-4 and 1.55e-4 m in other code."""
    folder = convert.folder_of("bouc_wen", tmp_path, shared / "data")
    linear = {"spring": {"stiffness": 123858.0}, "damper": {"damping": 88.41}}
    found = published_errors(model_of(folder, 2.0, **linear), folder)
    assert list(found.values()) == pytest.approx([1.74e-4, 1.55e-4], rel=0.02)


@pytest.mark.shared
def test_positioning_system_with_the_parameters_of_its_authors(shared, tmp_path):
    """95.1 kg, 203.5 N s/m, 20.4 N give 9.2 mm with their offset, refitted 6.35 mm."""
    folder = convert.folder_of("emps", tmp_path, shared / "data")
    authors = {"damper": {"damping": 203.5}, "coulomb_friction": {"sliding_force": 20.39}}
    (theirs,) = published_errors(model_of(folder, 95.11, **authors), folder).values()
    assert 6e-3 < theirs < 9.3e-3
    refitted = {"damper": {"damping": 216.2}, "coulomb_friction": {"sliding_force": 19.43}}
    (own,) = published_errors(model_of(folder, 96.87, **refitted), folder).values()
    assert own == pytest.approx(6.35e-3, rel=0.03)
