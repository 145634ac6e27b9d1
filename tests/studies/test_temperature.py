"""The temperature of a joint in a study: its clearance by thermal expansion."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import DocumentError
from shakerproc.models import EFFECTS, Element
from shakerproc.studies import read_study, run_study
from shakerproc.studies.kinds.base import jobs_of
from shakerproc.studies.study import at_temperature, clearance_of

STUDIES = Path(__file__).parents[2] / "configs" / "studies"


@pytest.fixture(scope="module")
def study():
    return read_study(STUDIES / "temperature.yaml")


def test_the_clearance_is_that_of_the_expansion_by_hand(study):
    """Hole 9.8 mm + play in POM C (110e-6 1/K), bushing 9.8 mm of steel (12e-6 1/K)."""
    for job, temperature in zip(jobs_of(study), (-40, -20, 0, 20, 40, 60, 80), strict=True):
        warmer = temperature - 20.0
        hole = 9.9e-3 * (1.0 + 110e-6 * warmer)
        bushing = 9.8e-3 * (1.0 + 12e-6 * warmer)
        assert_allclose(clearance_of(job.model), 0.5 * (hole - bushing), rtol=1e-12)


def test_a_squeezed_joint_has_no_clearance(study):
    assert clearance_of(at_temperature(study.model, study.warmth, 150.0)) == 0.0


def test_both_sides_of_an_offset_gap_grow_alike(study):
    gap = EFFECTS["offset_gap"](stiffness=1e5, clearance_positive=2e-5, clearance_negative=8e-5)
    elements = (*study.model.elements[:1], Element(gap, ("base", "coupon")))
    warmer = study.warmth.reference + 50.0
    model = replace(study.model, elements=elements)
    warm = at_temperature(model, study.warmth, warmer).elements[1].effect
    even = at_temperature(study.model, study.warmth, warmer)  # the same play, 0.1 mm
    grown = clearance_of(even) - 5e-5
    assert_allclose(warm.clearance_positive - 2e-5, grown, rtol=1e-9)
    assert_allclose(warm.clearance_negative - 8e-5, grown, rtol=1e-9)


@pytest.mark.slow
def test_the_table_holds_clearance_beside_omega_e(study):
    few = replace(study.vary[0], values=(273.15, 353.15), texts=("0 degC", "80 degC"))
    quick = replace(study, vary=(few,), measure=replace(study.measure, ensemble=0))
    result = run_study(quick, workers=2)
    assert np.all(np.diff(result.columns["clearance_m"]) > 0.0)
    assert np.all(np.diff(result.columns["peak_frequency_hz"]) < -20.0)
    assert result.verdict.startswith("held")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("coupon: ", "# coupon: ", "needs the key coupon"),
        ("pom_c_radial.yaml", "none.yaml", "expected a coupon file"),
        ("40 degC,", "40 m,", "vary: values"),
        ("models/bolted_coupon.yaml", "models/duffing.yaml", "needs a gap"),
    ],
)
def test_what_does_not_fit_is_told_with_its_place(tmp_path, old, new, message):
    (tmp_path / "coupons").mkdir()
    (tmp_path / "studies" / "models").mkdir(parents=True)
    configs = STUDIES.parent
    for name in ("materials.yaml", "coupons/pom_c_radial.yaml"):
        (tmp_path / name).write_text((configs / name).read_text())
    for name in ("bolted_coupon", "duffing"):
        text = (STUDIES / "models" / f"{name}.yaml").read_text()
        text = text.replace("{force on: mass}", "{base: acceleration}")
        (tmp_path / "studies" / "models" / f"{name}.yaml").write_text(text)
    path = tmp_path / "studies" / "temperature.yaml"
    path.write_text((STUDIES / "temperature.yaml").read_text().replace(old, new))
    with pytest.raises(DocumentError, match=message) as caught:
        read_study(path)
    assert "temperature.yaml:" in str(caught.value)
