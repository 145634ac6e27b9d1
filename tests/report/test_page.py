import base64
import hashlib
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from tests.small_campaign import write_campaign

from shakerproc.campaign import trends
from shakerproc.report.page.page import Report, Watched, html, write_report
from shakerproc.report.page.sections import ReportSection, ReportTable
from shakerproc.report.runs.drawing import page_figures
from shakerproc.runs import process_test, summary_of
from shakerproc.runs.panels import PanelScale
from shakerproc.runs.summary import (
    AnalysisSummary,
    CurveSummary,
    FlagSummary,
    LineSummary,
    PanelSummary,
    RunSummary,
)
from shakerproc.testlog import facts_of, read_testlog

PAYLOADS = (
    "<script>document.title='pwned'</script>",
    '"><img src=x onerror="document.title=\'pwned\'">',
    "<svg onload=document.title='pwned'>",
    "javascript:document.title='pwned'",
    "</title><script>document.title='pwned'</script>",
    "</style><script>document.title='pwned'</script>",
    "</script><script>document.title='pwned'</script>",
    "<!--<script>document.title='pwned'</script>",
    "{{ 7 * 7 }}{% raw %}",
    "<iframe src=https://example.org>",
    "<a href=javascript:alert(1)>x</a>",
    "' onmouseover='document.title=1",
    "&lt;script&gt;",
    "\u202egnp.exe\x1b[31m",
)


@pytest.fixture(scope="module")
def summary(tmp_path_factory):
    log = read_testlog(write_campaign(tmp_path_factory.mktemp("page"), 1))
    test = log.tests[0]
    return summary_of(process_test(log, test), "1", facts_of(test), "test_1.tdms", "ab" * 32)


@pytest.fixture(scope="module")
def many(summary):
    """91 runs that were processed, one that failed, one discarded."""
    runs = [replace(summary, test=str(i)) for i in range(1, 92)]
    odd = FlagSummary("clipping", "ch4", "312 samples stand at the limit")
    runs[3] = replace(runs[3], flags=(odd,))
    runs[5] = replace(runs[5], promised_s=9.0, flags=(FlagSummary("incomplete", "", "cut"),))
    failed = RunSummary("92", "failed", {"joint": "slot"}, error="no recording there")
    return [*runs, failed, RunSummary("93", "discarded")]


@pytest.fixture(scope="module")
def many_page(many):
    """Their page, which takes seconds to make."""
    return html(report_of(many))


class Page(HTMLParser):
    """Every tag with its attributes, and the text in order."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tags, self.text = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text.append(data)


def report_of(runs, **more):
    found = [
        trend
        for request in trends.standard_trends(runs)
        if (trend := trends.trend(runs, request, "ch3"))
    ]
    return Report("Campaign", runs, found, "ch3", "shakerproc batch testlog.yaml", **more)


def test_the_page_opens_with_what_matters(many_page):
    main = many_page.split("<main>")[1]
    shown = re.sub(r'<section class="contents".*?</section>', "", main, flags=re.DOTALL)
    text = "".join(Page(shown).text)
    places = [
        text.index(words)
        for words in (
            "91 of 92 tests processed, 1 failed, 1 incomplete, 2 flagged.",
            "Needs attention",
            "no recording there",
            "312 samples stand at the limit",
            "All runs",
            "Test 1,",
            "Test 91,",
            "Methods",
            "Bendat",
            "Provenance",
            "ab" * 32,
        )
    ]
    assert places == sorted(places)


def test_92_runs_stay_small_and_are_all_there(many, tmp_path):
    write_report(tmp_path / "report.html", report_of(many))
    size, of_one = (
        (tmp_path / "report.html").stat().st_size,
        len(html(report_of(many[:1])).encode()),
    )
    assert of_one + 499 * (size - of_one) / 91 < 10e6  # 500 such runs
    tags = Page((tmp_path / "report.html").read_text(encoding="utf-8")).tags
    articles = [attributes for tag, attributes in tags if tag == "article"]
    assert len(articles) == 92
    ids = {attributes.get("id") for _, attributes in tags}
    links = [a["href"] for tag, a in tags if tag == "a"]
    assert all(link.startswith("#") for link in links)
    assert {link[1:] for link in links} <= ids


def test_nothing_is_loaded_and_only_our_style_and_script_may_run(many_page):
    text = many_page
    page = Page(text)
    assert not [a for _, a in page.tags if "src" in a or a.get("href", "#")[0] != "#"]
    named = "http://www.w3.org/2000/svg"  # the name of a format, fetched by nobody
    assert "http" not in text.replace("http-equiv", "").replace(named, "")
    (policy,) = [a["content"] for t, a in page.tags if a.get("http-equiv")]
    for tag in ("style", "script"):
        (content,) = re.findall(rf"<{tag}>(.*?)</{tag}>", text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert not [a for _, a in page.tags if "style" in a]


def test_a_watched_page_loads_itself_again_and_keeps_its_policy(summary):
    waiting = tuple(str(i) for i in range(2, 40))
    page = Page(html(report_of([summary], watched=Watched(1.6, waiting))))
    assert ("meta", {"http-equiv": "refresh", "content": "2"}) in page.tags
    assert next(a for tag, a in page.tags if tag == "body")["data-refresh"] == "2"
    text = "".join(page.text)
    assert "Waiting for the recordings of: 2, 3," in text
    assert "21, 18 more." in text
    still = html(report_of([summary]))
    policy = next(a["content"] for _, a in page.tags if "content" in a and "http-equiv" in a)
    assert policy in still  # the same script, the same hash
    assert "data-refresh=" not in still
    assert "Watched" not in still


def poisoned(summary, payload):
    channels = tuple(replace(c, name=payload, at=payload) for c in summary.channels)
    curves = tuple(replace(c, channel=payload) for c in summary.curves)
    facts = {name: payload for name in summary.facts if not name.endswith(("_m", "_hz", "_g"))}
    return replace(
        summary,
        test=payload,
        channels=channels,
        curves=curves,
        facts={**summary.facts, **facts, payload: payload},
        recording=payload,
        sha256=payload,
        error=payload,
        detail=payload,
        start_time=payload,
        flags=(FlagSummary(payload, payload, payload),),
    )


@pytest.mark.parametrize("payload", PAYLOADS)
def test_text_from_logs_and_recordings_is_inert(summary, payload):
    section = ReportSection(
        payload, "evidence", [payload], [ReportTable(payload, [payload], [[payload]])]
    )
    run = poisoned(summary, payload)
    report = replace(report_of([run], sections=[section]), title=payload, command=payload)
    report = replace(report, verdict=payload, options={payload: payload})
    page = Page(html(report))
    plain = Page(html(report_of([summary])))
    assert {tag for tag, _ in page.tags} <= {tag for tag, _ in plain.tags} | {
        "ul",
        "li",
        "caption",
        "details",
        "summary",
        "pre",
    }
    assert sum(tag == "script" for tag, _ in page.tags) == 1
    assert not [a for _, a in page.tags for name in a if name.startswith("on")]
    assert "49" not in "".join(page.text[:20]) or "7 * 7" not in payload


def contrast(one, other):
    """WCAG 2 contrast of two colours."""

    def luminance(colour):
        parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_every_text_can_be_read():
    text = html(report_of([]))
    root = re.findall(r":root \{([^}]*)\}", text)[0]
    colours = dict(re.findall(r"--(\w+): (#\w{6})", root))
    for name in ("ink", "soft", "good", "bad", "warn", "link"):
        assert contrast(colours[name], "#ffffff") >= 4.5, name
        assert contrast(colours[name], colours["tint"]) >= 4.5, name


def test_every_text_can_be_read_in_the_dark_too():
    """Figures stay dark on white there, as they are drawn."""
    text = html(report_of([]))
    (dark,) = re.findall(r"prefers-color-scheme: dark\) \{\s*:root \{([^}]*)\}", text)
    colours = dict(re.findall(r"--(\w+): (#\w{6})", dark))
    for name in ("ink", "soft", "good", "bad", "warn", "link"):
        assert contrast(colours[name], colours["paper"]) >= 4.5, name
        assert contrast(colours[name], colours["tint"]) >= 4.5, name


def test_a_column_that_holds_nothing_is_left_out(many_page, summary):
    facts = {k: v for k, v in summary.facts.items() if k not in {"joint", "specimen"}}
    bare = "".join(Page(html(report_of([replace(summary, facts=facts)]))).text)
    assert "joint" in "".join(Page(many_page).text)
    table = bare[bare.index("All runs") :]
    assert "joint" not in table[: table.index("Click a heading")]
    assert "orientation" in table


def test_a_report_of_nothing_is_still_a_page():
    text = html(Report("Empty", [], [], ""))
    assert "0 of 0 tests processed" in text
    assert "None" not in text


def test_the_control_is_judged_in_words(summary):
    (told,) = [f.caption for f in page_figures(summary) if f.kind == "psd"]
    assert "within ±3 dB of the demanded level: kept" in told
    off = replace(summary.control, kept=False, beyond_alarm=0.3, worst_db=-7.0, worst_hz=50.0)
    (told,) = [
        f.caption for f in page_figures(replace(summary, control=off)) if f.kind == "psd"
    ]
    assert "in 30.0 % of the band, where 5 % may be: NOT KEPT, at worst -7.0 dB at 50" in told


def test_a_sweep_shows_its_control_between_its_limits(summary):
    curve = CurveSummary("level", "control 1", (5.0, 50.0, 500.0), (4.9, 5.0, 5.1), part="up")
    control = replace(summary.control, demanded=5.0)
    run = replace(summary, curves=(curve,), control=control, level_unit="g", alarm=None)
    (drawing,) = page_figures(run)
    assert drawing.kind == "level"
    for words in ("alarm ±3 dB", "abort ±6 dB", "mean control up", "[g]"):
        assert words in drawing.drawing


def test_a_table_in_front_holds_the_resonances_of_every_run(many, many_page):
    page = many_page
    front = page.split('id="resonances"')[1].split("</table>")[0]
    assert page.index('id="resonances"') < page.index('class="contents"')
    channel = next(c for c in many[0].channels if c.name == "ch3")
    wanted = sorted(peak.frequency_hz for peak in channel.response_peaks)
    rows = re.findall(r"<tr><td>(.*?)</td></tr>", front)
    assert len(rows) == 91
    cells = rows[0].split("</td><td>")
    told = [float(cell.partition(" (")[0]) for cell in cells[-len(wanted) :]]
    assert cells[0] == "1"
    assert told == [round(value, 1) for value in wanted]


def test_figures_of_further_analyses_stay_on_the_screen(summary):
    panel = PanelSummary(
        "Octaves", "", PanelScale("f [Hz]", logarithmic=False),
        PanelScale("rms [g]", logarithmic=False),
        (LineSummary("ch3", [1.0, 2.0], [3.0, 4.0], "ch3", "curve", 0),),
    )  # fmt: skip
    run = replace(summary, analyses=(AnalysisSummary("octaves", "Octaves", (), (), (panel,)),))
    page = html(report_of([run]))
    (drawn,) = re.findall(r"<figure([^>]*)><figcaption><b>Octaves", page)
    assert 'class="screen"' in drawn
    assert "in the folder of the run and on the page: Octaves." in page
