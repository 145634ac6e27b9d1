"""In which unit a displacement is shown."""

import pytest

from shakerproc.models.motion import shown_in


@pytest.mark.parametrize(
    ("largest", "motion", "shown"),
    [
        (None, "translation", "1 mm"), (2e-3, "translation", "1 mm"),
        (2e-5, "translation", "1e+03 µm"), (2e-9, "translation", "1e+06 nm"),
        (0.0, "translation", "1 mm"), (2e-5, "rotation", "1e+03 µrad"),
        (1e-12, "rotation", "1e+06 nrad"),
    ],
)  # fmt: skip
def test_a_thousandth_is_shown_in_a_unit_that_fits(largest, motion, shown):
    unit, factor = shown_in("m", motion, largest)
    assert f"{1e-3 * factor:.3g} {unit}" == shown


def test_a_velocity_is_shown_in_the_unit_of_its_motion():
    assert shown_in("m/s", "rotation", 1e-6) == ("rad/s", 1.0)
