"""Events of the log: drawn in both time figures, flagged where they cannot have happened."""

from tests.in_process import run
from tests.small_campaign import write_campaign

from shakerproc.report.runs.drawing import run_figure
from shakerproc.runs import open_test, process_recording, read_summary
from shakerproc.testlog import read_testlog

EVENTS = ", events: [{at: 2.5 s, note: bolt <b>tightened</b>}, {at: 90 s, note: door}]"


def test_events_are_drawn_where_they_happened_and_flagged_beyond_the_end(tmp_path):
    log = write_campaign(tmp_path, 1, more=EVENTS)
    test = read_testlog(log).tests[0]
    assert [(event.time, event.note) for event in test.events][1] == (90.0, "door")
    with open_test(read_testlog(log), test) as recording:
        result = process_recording(recording, test)
        figure = run_figure(result, "time", "test 1")
    for axis in figure.axes:
        assert 2.5 in [line.get_xdata()[0] for line in axis.lines]
    notes = {
        text.get_text(): text.xy[0] for text in figure.axes[0].texts if hasattr(text, "xy")
    }
    assert notes["bolt <b>tightened</b>"] == 2.5
    assert run("batch", log, "--workers", 1, "--no-figures", "--out", tmp_path / "out") == 0
    summary = read_summary(tmp_path / "out" / "runs" / "test_1" / "summary.json")
    (flag,) = [flag for flag in summary.flags if flag.kind == "event"]
    assert flag.message == (
        "door at 90 s: the recording ends at 6 s; correct the time in the log."
    )
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "bolt &lt;b&gt;tightened" in page
    assert "<b>tightened" not in page
