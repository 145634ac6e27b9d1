"""What studies find, against closed forms and the measured figures of the research page."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.closed_forms import oracles
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.report.models.curves import study_figure
from shakerproc.studies import Measure, Study, StudyRun, Variation, read_study, run_study
from shakerproc.studies.readings import (
    Spectrum,
    ensemble,
    excitation_of,
    in_words,
    peak_frequency,
    signal_of,
    simulated,
    spectrum,
    strobe,
)
from shakerproc.studies.results import VERDICTS, trend_of
from shakerproc.studies.study import Claim
from shakerproc.verification import claims_page, thesis_claims

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs" / "studies"


def gap(clearance=5e-3, damping_ratio=0.01):
    elements = (
        Element(EFFECTS["gap"](stiffness=1000.0, clearance=clearance), ("base", "mass")),
        Element(EFFECTS["damper"](damping_ratio=damping_ratio), ("base", "mass")),
    )
    return Model("gap", {"mass": 1.0}, elements, Excitation("force", "mass"))


SWEEP = StudyRun("sine sweep", level=5.0, from_hz=0.0, to_hz=30.0, duration=30.0)


def without_ensembles(name):
    study = read_study(CONFIGS / f"{name}.yaml")
    return replace(study, measure=replace(study.measure, ensemble=0))


@pytest.mark.slow
def test_omega_e_against_the_gap_is_what_was_measured():
    """The figures of research/SIMULATION.md, from another program, to a bin of 1/30 Hz."""
    found = run_study(without_ensembles("figure_4_02"), workers=2)
    measured = [5.033, 4.966, 4.933, 4.866, 4.733, 4.566, 4.200, 3.533]
    assert_allclose(found.columns["peak_frequency_hz"], measured, atol=0.02)
    assert_allclose(found.columns["force_over_ka"][1:], [10, 5, 2.5, 1, 0.5, 0.25, 0.1])
    assert found.verdict.startswith("held: peak_frequency_hz falls with a, 5.033 to 3.533")
    assert "bins 0.03333 Hz; sweep up from 0 to 30 Hz in 30 s" in found.method
    assert "F / (k a) from 0.1 to 10" in found.method


@pytest.mark.slow
def test_sweeping_down_is_lower_and_the_initial_condition_decides_figure_4_9():
    down = simulated(gap(20e-3), replace(SWEEP, down=True), growth=False)
    found = spectrum(down.acceleration, down.sample_rate, Measure())
    assert peak_frequency(found, Measure()) == pytest.approx(2.90, abs=0.02)
    for name, measured, verdict in (
        ("figure_4_09", (15.9, 13.05, 6.6), "did not hold: peak_frequency_hz falls with n"),
        ("figure_4_09_listing", (15.9, 17.25, 21.05), "held: peak_frequency_hz rises with n"),
    ):
        study = without_ensembles(name)
        few = replace(study.vary[0], values=(1.0, 3.0, 21.0), texts=("1", "3", "21"))
        result = run_study(replace(study, vary=(few,)), workers=2)
        assert_allclose(result.columns["peak_frequency_hz"], measured, atol=0.03)
        assert result.verdict.startswith(verdict)


@pytest.mark.slow
def test_a_chaotic_run_has_a_mean_and_a_spread():
    study = without_ensembles("gap_random")
    wide, seed = study.vary
    vary = (
        replace(wide, values=(20e-3,), texts=("20 mm",)),
        replace(seed, values=(1.0,), texts=("1",)),
    )
    measure = replace(study.measure, ensemble=6)
    result = run_study(replace(study, vary=vary, measure=measure))
    assert result.columns["chaotic"].all()
    assert np.all(result.columns["spread_hz"] >= 0.0)
    assert_allclose(result.columns["mean_hz"], result.columns["peak_frequency_hz"], atol=2.0)
    assert "1 of 1 runs are chaotic: ensemble only" in result.notes[0]


@pytest.mark.slow
def test_the_sweeps_of_figure_4_2_are_not_called_chaotic():
    """They lose contact, and a disturbance stays as it is; no neighbour departs visibly."""
    study = without_ensembles("figure_4_02")
    result = run_study(study, workers=2)
    assert not result.columns["chaotic"].any()
    worst = int(np.argmax(result.columns["growth"]))
    clearance = float(study.vary[0].values[worst])
    one = simulated(gap(clearance), SWEEP, growth=False).displacement
    near = simulated(
        gap(clearance), replace(SWEEP, initial_displacement=1e-10 * float(np.max(one)))
    ).displacement
    assert np.max(np.abs(near - one)) < 1e-2 * np.max(np.abs(one))


KEPT = (
    "figure_3_01",
    "figure_3_03",
    "figure_3_09",
    "figure_3_10",
    "figure_4_08",
    "figure_4_13",
    "figure_4_14",
    "figure_5_07",
    "figure_5_14",
    "gap_backbone",
    "gap_response",
)


@pytest.mark.slow
@pytest.mark.parametrize("name", KEPT)
def test_ready_made_studies_run_and_draw(name):
    result = run_study(read_study(CONFIGS / f"{name}.yaml"))
    sizes = {column.size for column in result.columns.values()}
    assert len(sizes) == 1
    assert result.method
    figure = study_figure(result)
    assert sum(axis.get_visible() for axis in figure.axes) >= len(result.panels)
    for panel in result.panels:
        for line in panel.lines:
            assert np.all(np.isfinite(line.x))
            assert np.all(np.isfinite(line.y))


def test_the_backbone_study_is_the_closed_form():
    result = run_study(read_study(CONFIGS / "gap_backbone.yaml"))
    first = result.columns["run"] == 0
    amplitude = result.columns["amplitude_m"][first]
    wide = amplitude > 1e-3
    exact = np.sqrt(1000.0) / (2.0 * np.pi) * oracles.gap_backbone(amplitude[wide], 5e-4)
    assert_allclose(result.columns["frequency_hz"][first][wide], exact, rtol=1e-3)


def bifurcation(values):
    return Study(
        title="t",
        kind="bifurcation",
        figure="",
        model=gap(),
        run=StudyRun("sine", level=5.0, frequency=4.0),
        measure=Measure(),
        vary=(Variation("F", "N", ("run.level",), values, tuple(f"{v:g} N" for v in values)),),
        claim=None,
        options=(("periods", 5.0), ("settle periods", 300.0)),
    )


def test_a_settled_motion_is_one_point_once_a_period():
    """At 4 Hz harmonic balance has one stable motion of the period of the force."""
    result = run_study(bifurcation((5.0, 8.0)))
    for level in (5.0, 8.0):
        points = result.columns["displacement_m"][result.columns["F_n"] == level]
        assert points.size == 5
        assert np.ptp(points) < 1e-6 * np.max(np.abs(points))


def test_strobe_takes_each_phase_where_it_is():
    """A linear mass answers with a sine; once a period at 4 phases it is 90 degrees apart."""
    spring = (Element(EFFECTS["spring"](stiffness=1000.0), ("base", "mass")),)
    damper = (Element(EFFECTS["damper"](damping=20.0), ("base", "mass")),)
    shaken = Model("linear", {"mass": 1.0}, spring + damper, Excitation("force", "mass"))
    run = StudyRun("sine", level=2.0, frequency=3.0)
    x, v, growth = strobe(shaken, run, periods=3, settle=40, phases=4)
    assert growth < 10.0
    omega = 6.0 * np.pi
    response = 2.0 / (1000.0 - omega**2 + 20j * omega)
    turn = np.exp(0.5j * np.pi * np.arange(4))
    assert_allclose(x, np.outer((response * turn).imag, np.ones(3)), atol=1e-9)
    assert_allclose(v, np.outer((1j * omega * response * turn).imag, np.ones(3)), atol=1e-7)


def test_looking_once_a_period_needs_a_sine():
    with pytest.raises(ValueError, match="needs a sine with a frequency"):
        strobe(gap(), SWEEP, periods=1, settle=1, phases=1)


@pytest.mark.parametrize("octaves", [False, True])
@pytest.mark.parametrize("down", [False, True])
def test_a_sweep_runs_from_end_to_end(octaves, down):
    """The frequency is the derivative of the phase, at both ends and half-way."""
    run = StudyRun(
        "sine sweep",
        level=1.0,
        from_hz=2.0,
        to_hz=32.0,
        duration=60.0,
        octaves=octaves,
        down=down,
    )
    signal = signal_of(run)
    middle = 8.0 if octaves else 17.0
    ends = (32.0, middle, 2.0) if down else (2.0, middle, 32.0)
    for time, frequency in zip((0.0, 30.0, 60.0), ends, strict=True):
        t = time + np.linspace(-1e-3, 1e-3, 3)
        y = signal(t)
        slope, bend = (y[2] - y[0]) / 2e-3, (y[2] - 2.0 * y[1] + y[0]) / 1e-6
        found = np.sqrt(slope**2 + (bend / (2.0 * np.pi * frequency)) ** 2) / (2.0 * np.pi)
        assert_allclose(found, frequency, rtol=2e-2)


def test_random_excitation_has_its_rms_and_band():
    run = StudyRun("random", level=3.0, from_hz=5.0, to_hz=50.0, duration=20.0, seed=4)
    samples = excitation_of(run)
    assert samples.size == 10_001
    assert_allclose(np.sqrt(np.mean(samples**2)), 3.0, rtol=1e-12)
    density = np.abs(np.fft.rfft(samples[:-1])) ** 2
    frequency = np.fft.rfftfreq(10_000, 1.0 / 500.0)
    inside = (frequency >= 5.0) & (frequency <= 50.0)
    assert density[~inside].sum() < 1e-6 * density.sum()
    assert not np.array_equal(samples, excitation_of(replace(run, seed=5)))
    with pytest.raises(ValueError, match="random excitation is no function of time"):
        signal_of(run)


def test_estimators_find_the_line_of_a_sine():
    time = np.arange(5000) / 500.0
    samples = np.sin(2.0 * np.pi * 7.3 * time) + 0.1 * np.sin(2.0 * np.pi * 3.1 * time)
    whole = spectrum(samples, 500.0, Measure())
    assert whole.bin_width == pytest.approx(0.1)
    assert peak_frequency(whole, Measure()) == pytest.approx(7.3)
    assert peak_frequency(whole, Measure(take="first")) == pytest.approx(3.1)
    assert peak_frequency(whole, Measure(to_hz=5.0)) == pytest.approx(3.1)
    welch = Measure(estimator="welch", segment=1000)
    assert peak_frequency(spectrum(samples, 500.0, welch), welch) == pytest.approx(
        7.5, abs=0.51
    )
    assert "Welch density in segments of 1000, bins 0.5 Hz" in in_words(welch, 0.5)
    flat = Spectrum(whole.frequency, np.ones_like(whole.density), 0.1)
    assert np.isnan(peak_frequency(flat, Measure()))
    with pytest.raises(ValueError, match="a run of 100 samples holds no segment of 1000"):
        spectrum(samples[:100], 500.0, welch)


def test_neighbouring_runs_begin_next_to_each_other():
    run = StudyRun("free", duration=1.0, initial_displacement=0.01)
    runs = ensemble(gap(), run, 3)
    starts = [motion.displacement[0] for motion in runs]
    assert len(set(starts)) == 3
    assert_allclose(starts, 0.01, rtol=1e-7)


@pytest.mark.parametrize(
    ("y", "expected"),
    [
        ((3.0, 2.0, 1.0), "falls"),
        ((1.0, 2.0, 3.0), "rises"),
        ((1.0, 3.0, 2.0), "neither"),
        ((1.0, 1.05, 1.0), "stays"),
        ((3.0, 3.05, 1.0), "falls"),
    ],
)
def test_a_trend_may_stray_by_one_bin(y, expected):
    assert trend_of(np.arange(3.0), np.array(y), 0.1) == expected


def test_an_interrupted_study_is_taken_up_again(tmp_path):
    study = bifurcation((5.0, 8.0))
    seen = []
    first = run_study(study, folder=tmp_path, progress=seen.append)
    assert sorted(seen) == ["5 N", "8 N"]
    kept = sorted(tmp_path.glob("*.npz"))
    assert len(kept) == 2
    stamps = [path.stat().st_mtime_ns for path in kept]
    kept[0].unlink()
    again = run_study(study, folder=tmp_path)
    assert_allclose(again.columns["displacement_m"], first.columns["displacement_m"])
    assert kept[1].stat().st_mtime_ns == stamps[1]
    other = run_study(replace(study, options=(("periods", 6.0),)), folder=tmp_path)
    assert other.columns["displacement_m"].size == 12
    assert len(list(tmp_path.glob("*.npz"))) == 4


def test_a_comment_is_a_caption_and_never_a_verdict():
    study = replace(bifurcation((5.0,)), claim=Claim("it is one point", comment="held"))
    result = run_study(study)
    assert (result.statement, result.verdict, result.comment) == (
        "it is one point",
        "not checked",
        "held",
    )


@pytest.fixture
def run_command(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        return CliRunner().invoke(build_app(), [str(argument) for argument in arguments])

    return run


def test_a_study_that_cannot_be_read_leaves_nothing(run_command, tmp_path):
    (tmp_path / "wrong.yaml").write_text("study: 1\ntitle: x\nkind: backbone2\n")
    done = run_command("study", "wrong.yaml", "--out", "here")
    assert done.exit_code != 0
    assert not (tmp_path / "here").exists()


def test_the_study_command_writes_table_figure_and_json(run_command, tmp_path):
    done = run_command(
        "study", CONFIGS / "figure_3_10.yaml", "--out", "here", "--json", "all.json"
    )
    assert done.exit_code == 0, done.output
    assert "stated: frequency rises with amplitude" in done.output
    document = json.loads((tmp_path / "all.json").read_text())
    assert document["schema"] == "shakerproc-studies/1"
    assert document["studies"][0]["figure"] == "3.10"
    folder = tmp_path / "here" / "figure_3_10"
    with (folder / "table.csv").open() as stream:
        assert next(csv.reader(stream)) == ["line", "x", "y"]
    assert (folder / "figure.png").stat().st_size > 5000


def test_the_study_command_wants_files_or_the_thesis(run_command):
    assert run_command("study").exit_code == 2
    assert run_command("study", "--thesis", CONFIGS / "figure_3_10.yaml").exit_code == 2


@pytest.mark.slow
def test_the_response_command_prints_folds_and_writes_the_curve(run_command, tmp_path):
    path = CONFIGS / "models" / "gap.yaml"
    done = run_command(
        "response", path, "--level", "0.5 N", "--from-hz", 4, "--to-hz", 6, "--json", "-",
        "--out", "here",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert document["schema"] == "shakerproc-response/1"
    assert document["force_over_gap_closing_force"] == {"gap between base and mass": 1.0}
    marks = [mark["kind"] for mark in document["branches"][0]["marks"]]
    assert marks.count("fold") == 2
    assert "contact lost at 5.03" in document["branches"][0]["ended"]
    with (tmp_path / "here" / "response.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == document["branches"][0]["points"]
    assert {row["stable"] for row in rows} == {"true", "false"}
    assert (tmp_path / "here" / "response.png").stat().st_size > 10_000
    again = run_command("response", path, "--level", "0.5 N", "--no-figures", "--no-backbone")
    assert "F / (k a) = 1" in again.output
    assert "unstable" in again.output


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--level", "5 g"], "expected a number with a unit of N"),
        (["--level", "0 N"], "must be above 0 N"),
        (["--level", "5 N", "--from-hz", "9", "--to-hz", "3"], "below --to-hz 3 Hz, not 9 Hz"),
        (["--level", "5 N", "--sensor", "ch9"], "no sensor 'ch9'"),
    ],
)
def test_wrong_usage_of_response_is_status_2(run_command, options, message):
    done = run_command("response", CONFIGS / "models" / "gap.yaml", *options)
    assert done.exit_code == 2
    assert message in " ".join(done.output.replace("│", " ").split())


def table_of(page):
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| ")]
    return {(row[0][2:], row[1]): row[-1].removesuffix(" |") for row in rows[1:]}


QUICK = ("eq. 3", "sec. 3", "eq. 5", "app. B", "table 6.7", "fig. 4.2", "ch. 4", "sec. 5")


@pytest.mark.slow
def test_the_table_of_claims_in_the_manual_is_current():
    """All statements; of the quick ones also the verdicts (the rest take a minute)."""
    written = table_of((ROOT / "docs" / "thesis_claims.md").read_text(encoding="utf-8"))
    claims = thesis_claims()
    assert list(written) == [(claim.where, claim.says) for claim in claims]
    assert set(written.values()) <= set(VERDICTS) - {"not checked"}
    outcomes = [claim.outcome() for claim in claims if claim.where.startswith(QUICK)]
    assert len(outcomes) > 10
    current = table_of(claims_page(outcomes))
    assert current == {key: written[key] for key in current}
