"""Names in any script, in pictures: nothing is warned of, and what cannot be drawn is told."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from shakerproc.report.figures import style, to_png
from shakerproc.report.figures.style import families, legible


def test_a_character_of_no_font_is_its_code_and_others_stay():
    assert legible("ω_e, Ångström, 5 µm\nx") == "ω_e, Ångström, 5 µm\nx"
    assert legible("a\x1bb") == r"a\x1bb"
    assert legible("\U0010fffdx") == r"\U0010fffdx"  # private use: in no font


@pytest.mark.parametrize("name", ["控制 1", "\x07bell", "résumé", "\U0010fffd"])
def test_a_picture_of_any_name_is_drawn_without_a_warning(tmp_path, name):
    """Warnings are errors here."""
    with style.look():
        picture = Figure()
        axis = picture.subplots()
        axis.plot(np.arange(3), label=name)
        axis.set_title(name)
        axis.legend()
        assert to_png.save(picture, tmp_path / "a.png").stat().st_size > 1000
    assert axis.get_title(loc="left") == legible(name)
    assert families()[0] == "DejaVu Sans"
