"""The report of 92 runs in a real browser: size, speed, silence, paper, grey."""

import json
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.report.browser import FOUND, Browser
from tests.report.drawn_points import drawn, lost, noted_plots
from tests.report.test_page import PAYLOADS, contrast, poisoned, report_of
from tests.small_campaign import write_campaign

from shakerproc.report.figures import style, to_svg
from shakerproc.report.figures.figure import Axis, Curve, Filling, Plot
from shakerproc.report.page import page as report_page
from shakerproc.report.page.page import write_report
from shakerproc.report.page.sections import PageFigure, ReportSection
from shakerproc.runs import process_test, summary_of
from shakerproc.testlog import facts_of, read_testlog

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(FOUND is None, reason="no Chromium, Chrome or Edge is installed"),
]
N_RUNS = 92
LARGEST = 1.97e6  # [byte]: 500 runs stay below 10 MB (python -m benchmarks.report)
LONGEST = 4.0  # until the page has settled: 0.3 to 0.7 on idle cores, others may use them [s]


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    """92 runs of four recordings: processed once, each told as its own test."""
    log = read_testlog(write_campaign(tmp_path_factory.mktemp("runs"), 4))
    made = [
        summary_of(process_test(log, t), "1", facts_of(t), f"test_{t.id}.tdms", "ab" * 32)
        for t in log.tests[:4]
    ]
    return [replace(made[i % len(made)], test=str(i + 1)) for i in range(N_RUNS)]


@pytest.fixture(scope="module")
def page(summaries, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_report(path, report_of(summaries))
    return path


@pytest.fixture(scope="module")
def browser():
    with Browser() as one:
        yield one


def wait_for(browser, condition):
    browser.run(
        "new Promise((done, fail) => { let n = 0; const look = () => "
        f"({condition}) ? done() : ++n > 200 ? fail('never') : setTimeout(look, 20); "
        "look(); })"
    )


def show(browser, selector):
    browser.run(f"document.querySelector('{selector}').scrollIntoView({{behavior: 'instant'}})")
    wait_for(browser, f"document.querySelector('{selector} .draw.live canvas')")


def test_92_runs_are_small_settle_at_once_and_ask_the_network_for_nothing(browser, page):
    assert page.stat().st_size <= LARGEST
    times = []
    while len(times) < 6 and min(times, default=9.0) >= LONGEST:
        browser.requests.clear()
        times.append(browser.open(page))
    assert min(times) < LONGEST, times
    show(browser, f"#run-{N_RUNS}")
    assert set(browser.requests) == {page.as_uri()}
    assert browser.errors == []


def test_a_figure_drawn_anew_has_the_numbers_of_the_run(browser, page, summaries):
    browser.open(page)
    show(browser, "#run-5 figure[data-kind=psd]")
    read = browser.run(
        "(() => { const f = read(document.querySelector('#run-5 figure[data-kind=psd] data'));"
        " return f.curves.map(c => ({name: c.label, x: c.x, y: c.y})); })()"
    )
    curves = {c.channel: c for c in summaries[4].curves if c.kind == "psd"}
    assert {c["name"] for c in read} >= set(curves)
    for c in read:
        if c["name"] in curves:
            wanted = curves[c["name"]]
            assert_allclose(c["x"], wanted.x, atol=1e-3 * max(wanted.x))
            assert_allclose(np.log(c["y"]), np.log(wanted.y), atol=0.01)


def test_a_trend_drawn_anew_has_its_error_bars(browser, page):
    browser.open(page)
    show(browser, "#trends figure")
    missing = browser.run(
        "(() => { const f = read(document.querySelector('#trends figure data'));"
        " return f.curves.filter(c => c.kind === MARKS).map(c =>"
        " c.x.filter((x, i) => !(c.bars.get(`${x} ${c.y[i]}`) > 0))); })()"
    )
    assert missing
    assert not any(missing)
    assert browser.errors == []


def test_a_name_takes_its_curve_away_and_back(browser, page):
    browser.open(page)
    show(browser, "#run-2 figure[data-kind=coherence]")
    seen = (
        "[...alive].find(([box]) => box.closest('#run-2 figure[data-kind=coherence]'))[1]"
        ".series.slice(1).map(s => s.show)"
    )
    click = "document.querySelector('#run-2 figure[data-kind=coherence] .legend span').click()"
    assert browser.run(seen) == [True, True]
    browser.run(click)
    assert browser.run(seen) == [False, True]
    browser.run(click)
    assert browser.run(seen) == [True, True]


def test_dragging_zooms_and_two_clicks_show_the_whole(browser, page):
    browser.open(page)
    show(browser, "#run-3 figure[data-kind=gain]")
    box = json.loads(browser.run(
        "JSON.stringify(document.querySelector('#run-3 figure[data-kind=gain] .u-over')"
        ".getBoundingClientRect())"
    ))  # fmt: skip
    scale = (
        "(s => [s.min, s.max])([...alive].find(([b]) => "
        "b.closest('#run-3 figure[data-kind=gain]'))[1].scales.x)"
    )
    low, high = browser.run(scale)
    y = box["y"] + box["height"] / 2

    def mouse(kind, share, count=0, buttons=0):
        browser.ask(
            "Input.dispatchMouseEvent",
            type=kind,
            x=box["x"] + share * box["width"],
            y=y,
            button="left" if kind != "mouseMoved" else "none",
            clickCount=count,
            buttons=buttons,
        )

    mouse("mouseMoved", 0.25)
    mouse("mousePressed", 0.25, 1, 1)
    mouse("mouseMoved", 0.5, 0, 1)
    mouse("mouseReleased", 0.5, 1)
    quarter = low + 0.25 * (high - low)
    assert_allclose(browser.run(scale), [quarter, quarter + 0.25 * (high - low)], rtol=0.02)
    read = browser.run(
        "document.querySelector('#run-3 figure[data-kind=gain] .read').textContent"
    )
    assert re.match(r"frequency [\d.]+ Hz\nch3: [\d.]+\nch4: [\d.]+", read)
    for count in (1, 2):
        mouse("mousePressed", 0.5, count, 1)
        mouse("mouseReleased", 0.5, count)
    assert_allclose(browser.run(scale), [low, high])


def test_ticked_runs_are_laid_over_each_other(browser, page):
    browser.open(page)
    browser.run("rows.slice(0, 3).forEach(row => row.querySelector('.pick').click())")
    assert browser.run("document.querySelectorAll('#overlay-plot canvas').length") == 1
    keys = browser.run(
        "[...document.querySelectorAll('#overlay-keys span')].map(k => k.textContent)"
    )
    assert [key.split(",")[0].strip() for key in keys] == ["test 1", "test 2", "test 3"]
    widths = browser.run(
        "[...document.querySelectorAll("
        "'#overlay-keys path, #run-1 figure[data-kind=psd] .legend path')]"
        ".map(p => p.getBoundingClientRect().width)"
    )
    assert len(set(widths)) == 1  # samples of the lines, as of every figure
    kinds = browser.run(
        "[...document.getElementById('overlay-kind').options].map(o => o.value)"
    )
    assert {"psd", "gain", "coherence", "time"} <= set(kinds)
    for kind in kinds:
        browser.run(
            f"(s => {{ s.value = '{kind}'; s.dispatchEvent(new Event('change')); }})"
            "(document.getElementById('overlay-kind'))"
        )
        assert browser.run("laid.series.length") >= 4
    browser.run("document.getElementById('overlay-clear').click()")
    assert browser.run("document.getElementById('overlay').hidden")
    assert browser.errors == []


def test_rows_are_sorted_and_chosen(browser, page):
    browser.open(page)
    browser.run("document.querySelector('#all th[data-name=\"peak frequency [Hz]\"]').click()")
    column = "rows.map(r => Number(r.querySelectorAll('td')[10].textContent))"
    found = browser.run(column)
    assert found == sorted(found)
    chosen = browser.run(
        "(s => { s.value = s.options[1].value; s.dispatchEvent(new Event('change'));"
        " return [s.value, rows.filter(r => !r.hidden).map(r => r.textContent)]; })"
        "(document.querySelector('#choices select'))"
    )
    assert chosen[1]
    assert all(chosen[0] in text for text in chosen[1])
    assert len(chosen[1]) < N_RUNS


def test_a_column_is_held_against_a_number(browser, page, summaries):
    browser.open(page)
    counted = "rows.filter(row => !row.hidden).length"
    shown = f"(text => {{ filter.value = text; choose(); return {counted}; }})"
    beyond = sum(run.facts["clearance_m"] > 4e-5 for run in summaries)
    assert 0 < beyond < N_RUNS
    assert browser.run(f"{shown}('clearance>0.04')") == beyond
    assert browser.run(f"{shown}('clearance<=0.04 random')") == N_RUNS - beyond
    assert browser.run(f"{shown}('clearance>9')") == 0
    assert browser.run(f"{shown}('')") == N_RUNS


def test_without_scripts_every_run_is_there(browser, page):
    browser.ask("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.open(page, settle=False)
        document = browser.ask("DOM.getDocument")["root"]["nodeId"]

        def count(selector):
            found = browser.ask("DOM.querySelectorAll", nodeId=document, selector=selector)
            return len(found["nodeIds"])

        assert count("article.run") == N_RUNS
        assert count("article.run svg.plot") >= 4 * N_RUNS
        assert count("canvas") == 0
        assert count(".scripted:not([hidden])") == 0
    finally:
        browser.ask("Emulation.setScriptExecutionDisabled", value=False)


def test_paper_shows_the_still_figures_of_every_run(browser, page):
    browser.open(page)
    show(browser, "#run-1")
    browser.ask("Emulation.setEmulatedMedia", media="print")
    try:
        seen = browser.run(
            "[...document.querySelectorAll('article.run')].filter(a => "
            "[...a.querySelectorAll('svg.plot')].every(s => "
            "getComputedStyle(s).visibility === 'visible' && "
            "s.getBoundingClientRect().height > 40)).length"
        )
        drawn = browser.run(
            "[...document.querySelectorAll('.draw > .uplot, .scripted, .picks, nav')]"
            ".filter(e => getComputedStyle(e).display !== 'none').length"
        )
    finally:
        browser.ask("Emulation.setEmulatedMedia", media="")
    assert (seen, drawn) == (N_RUNS, 0)


def test_all_92_are_in_the_pdf(page, tmp_path, monkeypatch):
    monkeypatch.setenv(report_page.BROWSER_VARIABLE, FOUND)
    data = report_page.print_report(page, tmp_path / "report.pdf").read_bytes()
    assert data.startswith(b"%PDF")
    titles = [
        bytes.fromhex(text.decode("ascii")).decode("utf-16")
        for text in re.findall(rb"/Title <([0-9A-F]+)>", data)
    ]  # of the outline, in which each run has an entry
    runs = [int(found.group(1)) for t in titles if (found := re.match(r"Test (\d+),", t))]
    assert runs == list(range(1, N_RUNS + 1))
    n_pages = len(re.findall(rb"/Type /Page\b", data))
    assert N_RUNS / 2 < n_pages < N_RUNS + 12


def test_no_text_of_a_log_runs(browser, summaries, tmp_path):
    runs = [replace(poisoned(summaries[0], p), test=p) for p in PAYLOADS]
    write_report(tmp_path / "poisoned.html", report_of(runs))
    browser.requests.clear()
    browser.open(tmp_path / "poisoned.html")
    for row in range(len(PAYLOADS)):
        browser.run(f"rows[{row}].querySelector('.pick')?.click()")
    show(browser, "#run-1")
    assert browser.run("document.title") == "Campaign"
    assert browser.run("document.querySelectorAll('img, iframe, script').length") == 1
    assert set(browser.requests) == {(tmp_path / "poisoned.html").as_uri()}


def test_curves_differ_without_their_colours():
    """Of two styles either the dash differs or the darkness."""
    for (i, one), (j, other) in combinations(enumerate(style.COLOURS), 2):
        apart = style.DASHES[i] != style.DASHES[j] or contrast(one, other) > 2.0
        assert apart, (i, j)


def test_pictures_of_the_page_in_colour_and_in_grey(browser, page, tmp_path):
    from PIL import Image

    browser.open(page)
    show(browser, "#run-1")
    browser.picture(tmp_path / "colour.png")
    browser.greyscale()
    browser.picture(tmp_path / "grey.png")
    browser.greyscale(off=True)
    with Image.open(tmp_path / "colour.png") as image:
        colour = np.asarray(image.convert("RGB"), dtype=int)
    with Image.open(tmp_path / "grey.png") as image:
        grey = np.asarray(image.convert("RGB"), dtype=int)
    assert np.max(np.ptp(colour, axis=2)) > 60
    assert np.max(np.ptp(grey, axis=2)) <= 3
    assert len(np.unique(grey)) > 30


def test_every_text_stands_out_from_its_ground(browser, page):
    browser.open(page)
    found = browser.run(
        "[...new Set([...document.querySelectorAll("
        "'main p, main td, main th, main a, main figcaption, main li, main h2, nav a')]"
        ".filter(e => e.offsetParent).map(e => getComputedStyle(e).color))]"
    )
    for colour in found:
        red, green, blue = map(int, re.findall(r"\d+", colour)[:3])
        assert contrast(f"#{red:02x}{green:02x}{blue:02x}", "#f5f6f7") >= 4.5, colour


def test_printed_limits_are_thinner_than_the_curves(page, browser):
    browser.ask("Emulation.setEmulatedMedia", media="print")
    browser.open(page)
    ink = """[...document.querySelectorAll("svg.plot path[class^=c]")].map(path => {
        const look = getComputedStyle(path);
        return [path.classList.contains("thin"),
                parseFloat(look.strokeWidth) * parseFloat(look.strokeOpacity)];
    })"""
    drawn = browser.run(ink)
    browser.ask("Emulation.setEmulatedMedia", media="")
    limits = [width for thin, width in drawn if thin]
    curves = [width for thin, width in drawn if not thin]
    assert limits
    assert max(limits) < 0.25 * min(curves)


def every_kind_of_plot():
    """Plots of curves whose places differ, stand together, repeat, fall or are not there."""
    rng = np.random.default_rng(3)
    even, few = np.linspace(0.0, 10.0, 60), np.array([1.0, 1.0, 4.0, 4.0, 4.0, 9.0])
    other, steps = np.sort(rng.random(40)) * 10.0, np.array([0.0, 3.0, 3.0, 7.0, 7.0, 10.0])
    broken = np.where(np.arange(60) % 13 == 5, np.nan, 2.0 + np.sin(even))
    y, high = np.arange(1.0, 7.0), np.array([1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    marks = {"points": True, "hollow": [True, False, True, False, False, True]}
    kinds = {
        "lines": [
            Curve("a", even, broken, 0),
            Curve("b", other, 1 + other / 9, 1),
        ],
        "steps": [
            Curve("a", even, broken, 0),
            Curve("b", steps, high, 1, thin=True),
        ],
        "falling": [
            Curve("a", steps[::-1], high, 0),
            Curve("b", other, other / 3, 1),
        ],
        "marks": [
            Curve("a", few, y, 0, bars=[0.2] * 6, **marks),
            Curve("b", few + 0.0, y[::-1] + 0.5, 1, points=True),
            Curve("c", np.array([4.0, 5.0]), np.array([5.5, 2.5]), 2, points=True),
        ],
        "marks on a line": [
            Curve("a", even, broken, 0, wide=True),
            Curve("b", few[::-1], y, 3, points=True),
        ],
        "dots": [
            Curve("a", np.repeat(other[:9], 3), rng.random(27) * 6.0, 0, dots=True),
            Curve("b", few, y, 1, dots=True),
        ],
        "areas": [
            Filling("a", even, broken - 0.5, broken + 0.5, 0),
            Filling("b", other, other / 3, 1 + other / 3, 1),
            Curve("c", steps, high, 2),
        ],
    }  # fmt: skip
    return {
        f"{name}, {'logarithmic' if log else 'even'} x": Plot(
            items,
            Axis("x [Hz]", 0.5 if log else -0.5, 11.0, logarithmic=log),
            Axis("y [-]", 0.1, 8.0, logarithmic=name == "lines"),
        )
        for name, items in kinds.items()
        for log in (False, True)
    }


def test_no_kind_of_figure_loses_a_point(browser, tmp_path):
    with noted_plots() as plots:
        drawings = [
            PageFigure(name, "", to_svg.plot(plot, title=name))
            for name, plot in every_kind_of_plot().items()
        ]
        section = ReportSection("Figures", "figures", figures=drawings)
        write_report(tmp_path / "kinds.html", replace(report_of([]), sections=[section]))
    browser.open(tmp_path / "kinds.html")
    found = drawn(browser)
    assert len(found) == len(drawings)
    titles = {
        plot: title for title, plot in zip(every_kind_of_plot(), plots.values(), strict=True)
    }
    assert {titles[plots[one["value"]]]: lost(one, plots[one["value"]]) for one in found} == (
        dict.fromkeys(titles.values(), 0)
    )


def test_the_figures_of_runs_and_trends_lose_no_point(browser, summaries, tmp_path):
    with noted_plots() as plots:
        write_report(tmp_path / "page.html", report_of(summaries[:8]))
    browser.open(tmp_path / "page.html")
    found = drawn(browser)
    assert len(found) > 40
    assert sum(lost(one, plots[one["value"]]) for one in found) == 0
