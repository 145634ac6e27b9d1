"""``shakerproc modal`` from a log and recordings to tables, and what it says of bad input."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.modal_signals import band_limited, draw, superposition
from tests.in_process import run

from shakerproc.errors import DocumentError
from shakerproc.testlog import read_testlog

SENSORS = "".join(
    f"  a{i}: {{role: response, position: [{100 * i} mm, 0 mm, 0 mm], direction: z}}\n"
    for i in range(1, 9)
)
LOG = f"""\
testlog: 1
channels:
  force: {{role: force}}
{SENSORS}processing: {{crop: none}}
modal: {{band: {{from: 3 Hz, to: 205 Hz}}, order: 30}}
tests:
"""


def write_csv(path, structure, sensors=8):
    time = np.arange(structure.response.shape[1]) / structure.sample_rate
    names = [f"a{i} [m/s^2]" for i in range(1, sensors + 1)]
    rows = np.column_stack([time, structure.force[0], structure.response[:sensors].T])
    header = ",".join(["time [s]", "force [N]", *names])
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.8g")


@pytest.fixture(scope="module")
def structure():
    return draw(np.random.default_rng(11), 4, noise_db=40.0, duration=10.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, structure):
    folder = tmp_path_factory.mktemp("modal")
    (folder / "recordings").mkdir()
    write_csv(folder / "recordings" / "1.csv", structure)
    write_csv(folder / "recordings" / "2.csv", structure, sensors=5)
    return folder


@pytest.fixture
def analysed(folder, capsys):
    def analyse(tests, *options, log=LOG, status=0):
        path = folder / f"log_{abs(hash((tests, log)))}.yaml"
        path.write_text(log + tests)
        out = folder / f"out_{path.stem}"
        assert run("modal", path, "--out", out, *options) == status
        return capsys.readouterr(), out

    return analyse


def test_a_log_becomes_modes_shapes_tracks_and_figures(analysed, structure):
    tests = """\
  - {id: 1, recording: 1.csv, excitation: random, level: 1 N rms, from: 3 Hz, to: 215 Hz}
  - {id: 2, recording: 2.csv, excitation: random, level: 1 N rms, from: 3 Hz, to: 215 Hz,
     channels: {a6: {role: ignore}, a7: {role: ignore}, a8: {role: ignore}}}
"""
    done, out = analysed(tests)
    document = json.loads((out / "report.json").read_text())
    assert document["schema"] == "shakerproc-modal/1"
    for test in document["tests"]:
        modes = test["modes"]
        assert [m["frequency_hz"]["value"] for m in modes] == pytest.approx(
            structure.frequency, rel=1e-3
        )
        assert [m["damping"]["value"] for m in modes] == pytest.approx(
            structure.damping, rel=0.05
        )
    assert [len(track["sightings"]) for track in document["tracks"]] == [2] * 4
    assert min(track["least_mac"] for track in document["tracks"]) > 0.99
    assert "have not the same sensors" in done.out
    assert "4 modes from 3 to 205 Hz, 8 sensors, input force" in done.out
    drawn = {path.name for path in out.glob("*.png")}
    kinds = ("stabilisation", "synthesis", "shapes", "mac")
    assert drawn == {f"test_{i}_{k}.png" for i in (1, 2) for k in kinds} | {
        "modes_over_tests.png"
    }
    lines = (out / "shapes.csv").read_text().splitlines()
    assert len(lines) == 1 + 4 * 8 + 4 * 5
    page = (out / "report.html").read_text()
    moving = re.findall(r'class="moving"><path class="c0" d="([^"]+)"><animate', page)
    still = re.findall(r'class="still"><path class="c0" d="([^"]+)"', page)
    assert len(moving) == 8  # a shape of every mode of both tests swings
    assert still == moving  # and is drawn at its largest
    assert (
        "@media print { svg .still { display: inline; } svg .moving { display: none; } }"
        in page
    )
    assert "|H1| [g/N]" in page


def test_output_only_where_the_log_wants_it(analysed, structure):
    log = LOG.replace("order: 30", "order: 30, inputs: none")
    done, out = analysed("  - {id: 1, recording: 1.csv}\n", "--no-figures", log=log)
    found = json.loads((out / "report.json").read_text())["tests"][0]["modes"]
    places = np.array([mode["frequency_hz"]["value"] for mode in found])
    assert places.size >= 2
    for place in places:  # 10 s tell no more
        assert np.min(np.abs(place / structure.frequency - 1.0)) < 0.02
    assert "input not measured" in done.out
    assert "jackknife" in done.out


@pytest.mark.parametrize(
    ("log", "test", "says"),
    [
        (LOG.replace("205 Hz", "400 Hz"), "", "lies outside the data, which reach to 256 Hz"),
        (LOG.replace("order: 30", "inputs: control"), "", "no channel has the role control"),
        (LOG.replace("to: 205 Hz", "to: 7 Hz"), "", "order 30 is too high for 41 lines"),
        (LOG, ", excitation: sine, frequency: 9 Hz", "reaches single frequencies"),
        (LOG.replace("role: response", "role: ignore"), "", "no channel has the role response"),
    ],
)
def test_what_cannot_be_done_is_one_line_with_the_remedy(analysed, log, test, says):
    done, _ = analysed(
        f"  - {{id: 1, recording: 1.csv{test}}}\n", "--no-figures", log=log, status=1
    )
    lines = [line for line in done.err.splitlines() if "left out" in line]
    assert len(lines) == 1
    assert says in lines[0]


def test_sensors_without_position_and_a_single_one_are_told(analysed):
    bare = LOG.replace(SENSORS, "  a1: {role: response}\n  a2: {role: response}\n")
    line = "  - {id: 1, recording: 1.csv}\n"
    done, _ = analysed(line, "--no-figures", log=bare)
    assert "no position for a1, a2: shapes are drawn over the sensors' order" in done.out
    done, _ = analysed(line, "--no-figures", log=bare.replace("  a2: {role: response}\n", ""))
    assert "one response only: modes have no shape" in done.out


@pytest.mark.parametrize(
    ("good", "bad", "says"),
    [
        ("direction: z", "direction: up", "expected x, y, z, -x, -y, -z or three numbers"),
        ("[100 mm,", "[100,", "expected a number with a unit of m"),
        ("to: 205 Hz", "to: 2 Hz", "expected from below to"),
        ("order: 30", "keep: [300 Hz]", "expected a frequency of the band from 3 to 205 Hz"),
        ("order: 30", "order: 2", "order"),
        ("order: 30", "mode: 3", 'did you mean "modes"'),
    ],
)
def test_mistakes_in_the_log_have_line_and_column(tmp_path: Path, good, bad, says):
    path = tmp_path / "log.yaml"
    path.write_text(LOG.replace(good, bad, 1) + "  - {id: 1}\n")
    with pytest.raises(DocumentError, match=r"log\.yaml:\d+:\d+: ") as told:
        read_testlog(path)
    assert says in str(told.value)


@pytest.fixture(scope="module")
def two_campaigns(tmp_path_factory):
    """Two logs: a structure at two clearances, 1 % apart, and another one, 2 % lower."""
    folder = tmp_path_factory.mktemp("campaigns")
    made = draw(np.random.default_rng(3), 3, noise_db=50.0, duration=8.0)
    frequency = np.array([30.0, 75.0, 140.0])
    for number, factor in enumerate((1.0, 0.99, 0.98), 1):
        fine = band_limited(np.random.default_rng(number), 1, made.force.shape[1])
        load = made.shapes[:, [made.driven[0]]] @ fine
        response = superposition(
            factor * frequency, np.full(3, 0.01), made.shapes, load, made.sample_rate
        )
        noise = np.random.default_rng(10 + number).standard_normal(response.shape)
        own = replace(
            made, force=fine[:, ::8], response=response + 1e-3 * response.std() * noise
        )
        write_csv(folder / f"{number}.csv", own)
    log = LOG.replace("modal:", "recordings: .\nmodal:")
    line = (
        "  - {{id: {0}, recording: {0}.csv, excitation: random, level: 1 N rms,\n"
        "     from: 3 Hz, to: 215 Hz, clearance: {1} mm}}\n"
    )
    (folder / "old.yaml").write_text(log + line.format(1, 0) + line.format(2, 0.05))
    (folder / "new.yaml").write_text(log + line.format(3, 0))
    return folder


def test_every_mode_is_followed_over_clearance_and_to_another_campaign(two_campaigns, capsys):
    out = two_campaigns / "out"
    logs = (two_campaigns / "old.yaml", "--against", two_campaigns / "new.yaml")
    assert run("modal", *logs, "--out", out) == 0
    with (out / "mode_trends.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["mode"] for row in rows} == {"1", "2", "3"}
    for number, factors in (("clearance [mm]", (1.0, 0.98, 0.99)), ("campaign", None)):
        points = [r for r in rows if r["mode"] == "2" and r["against"] == number]
        assert points
        if factors is not None:
            found = sorted(float(row["frequency_hz"]) for row in points[:3])
            assert found == pytest.approx(sorted(75.0 * np.array(factors)), rel=1e-3)
    told = capsys.readouterr().out
    assert "The frequency of mode 2 (75 Hz) falls from" in told
    assert (out / "trends" / "mode_2_against_campaign.png").stat().st_size > 10_000
    tracks = json.loads((out / "report.json").read_text())["tracks"]
    assert [len(track["sightings"]) for track in tracks] == [3, 3, 3]
    assert min(track["least_mac"] for track in tracks) > 0.99
    assert "Frequency of mode 2" in (out / "report.html").read_text()


@pytest.mark.slow
def test_batch_finds_the_modes_too(folder, capsys):
    path = folder / "batch.yaml"
    path.write_text(LOG + "  - {id: 1, recording: 2.csv, channels: {a6: {role: ignore}, "
                    "a7: {role: ignore}, a8: {role: ignore}}}\n")  # fmt: skip
    out = folder / "batch"
    assert run("batch", path, "--modal", "--no-figures", "--workers", 1, "--out", out) == 0
    assert len((out / "modal" / "modes.csv").read_text().splitlines()) == 1 + 4
    page = (out / "report.html").read_text()
    assert "4 modes" in page
    assert page.count('class="moving"') == 4  # the shapes swing in the report of the batch too
    assert "modal/report.html" in page
    assert "modes:" in capsys.readouterr().err


@pytest.fixture
def with_a_dead(folder, structure):
    """Recordings in which the force or the first sensor stands at 0."""
    for name, number in (("3.csv", 1), ("4.csv", 2)):
        rows = np.loadtxt(folder / "recordings" / "1.csv", delimiter=",", skiprows=1)
        rows[:, number] = 0.0
        header = (folder / "recordings" / "1.csv").read_text().partition("\n")[0]
        target = folder / "recordings" / name
        np.savetxt(target, rows, delimiter=",", header=header, comments="", fmt="%.8g")


@pytest.mark.usefixtures("with_a_dead")
def test_a_dead_input_is_an_error_in_one_line(analysed):
    told, _ = analysed("  - {id: 1, recording: 3.csv}\n", status=1)
    (line,) = [one for one in told.err.splitlines() if "constant" in one]
    assert "input force is constant. Stands at exactly 0 N" in line


@pytest.mark.usefixtures("with_a_dead")
def test_a_dead_sensor_is_told_beside_the_modes_of_the_others(analysed):
    told, out = analysed("  - {id: 1, recording: 4.csv}\n", "--no-figures")
    assert "a1 is constant: its modes may be wrong. Stands at exactly 0 m/s" in told.out
    assert (out / "modes.csv").exists()


def test_what_is_wrong_with_a_sensor_that_measures_is_told_beside_its_modes(
    analysed, folder, structure
):
    spoiled = structure.response.copy()
    spoiled[2, 5000] += 80.0 * np.std(spoiled[2])
    write_csv(folder / "recordings" / "spike.csv", replace(structure, response=spoiled))
    test = "  - {id: 1, recording: spike.csv, excitation: random, from: 3 Hz, to: 215 Hz}\n"
    done, out = analysed(test, "--no-figures")
    assert "spike (a3): An isolated spike" in done.out
    (one,) = json.loads((out / "report.json").read_text())["tests"]
    assert any(note.startswith("spike (a3)") for note in one["notes"])
