"""A campaign beside an earlier one: modes paired, lone tests told, bad folders one line."""

from dataclasses import replace

import pytest

from shakerproc import files
from shakerproc.campaign.earlier import change_columns, changes, read_earlier
from shakerproc.errors import TableError
from shakerproc.report.figures.units import USUAL
from shakerproc.report.page.page import EXAMPLE
from shakerproc.report.trends import earlier_section


def run_of(test, *peaks, level=1.0):
    """Return a run whose response has peaks of these frequencies [Hz], heights and dampings."""
    (channel,) = EXAMPLE.channels
    (model,) = channel.psd_peaks
    found = tuple(
        replace(model, frequency_hz=f, height=h, damping_ratio=z) for f, h, z in peaks
    )
    return replace(
        EXAMPLE, test=test, channels=(replace(channel, psd_peaks=found),), measured_level=level
    )


def test_modes_are_paired_by_frequency_and_changes_told():
    now = [run_of("a", (95.0, 20.0, 0.03), (205.0, 1.0, 0.01), level=2.0), run_of("new")]
    then = [run_of("a", (100.0, 10.0, 0.02), (400.0, 5.0, 0.01)), run_of("old")]
    found = changes(now, then)
    columns = change_columns(found.rows)
    assert columns["frequency_before_hz"] == [100.0, None, 400.0]
    assert columns["frequency_now_hz"] == [95.0, 205.0, None]
    assert columns["shift_hz"] == [-5.0, None, None]
    assert columns["height_difference_db"][0] == pytest.approx(3.0103)  # twice the density
    assert columns["level_difference_db"][0] == pytest.approx(6.0206)  # twice the amplitude
    assert columns["damping_ratio_before"][0] == pytest.approx(0.02)
    assert (found.only_now, found.only_before) == (("new",), ("old",))


def test_the_section_tells_shifts_new_and_lost_modes_and_draws_both(tmp_path):
    then = run_of("a", (100.0, 10.0, 0.02), (400.0, 5.0, 0.01))
    files.write_json(tmp_path / "report.json", {"title": "Spring", "runs": [then]})
    earlier = read_earlier(tmp_path)
    assert earlier.runs == (then,)
    section = earlier_section(
        [run_of("a", (95.0, 20.0, 0.03), (205.0, 1, 0.1))], earlier, USUAL
    )
    assert "1 of 1 peaks moved by more than a bin" in section.paragraphs[0]
    assert "from 100 to 95 Hz (-5.0 %)" in section.paragraphs[0]
    (table,) = section.tables
    changed = table.columns.index("change")
    assert [row[changed] for row in table.rows] == ["-5.00 %", "new", "gone"]
    (drawing,) = section.figures
    assert "response, earlier" in drawing.drawing


@pytest.mark.parametrize(
    "content", [None, "{", "[]", '{"title": "a"}', '{"title": "a", "runs": [{"test": 1}]}']
)
def test_a_folder_that_no_batch_wrote_is_one_line(tmp_path, content):
    if content is not None:
        (tmp_path / "report.json").write_text(content)
    with pytest.raises(TableError, match=r"earlier batch wrote|run that batch again") as caught:
        read_earlier(tmp_path)
    assert "\n" not in str(caught.value)
