"""Decks of models: what their tables hold, and what no deck can hold."""

import csv

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import ModelError
from shakerproc.exchange.nastran_decks import cards_of, forces_of_deck, transient_deck
from shakerproc.model_files.exchanged import check_places, deck_of_model
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.bouc_wen import BoucWen
from shakerproc.models.effects.coulomb_friction import CoulombFriction
from shakerproc.models.effects.cubic_stiffness import CubicStiffness
from shakerproc.models.effects.damper import Damper
from shakerproc.models.effects.gap import Gap
from shakerproc.models.effects.jump_gap import JumpGap
from shakerproc.models.effects.spring import Spring
from shakerproc.models.effects.stop import Stop
from shakerproc.recordings import write_tdms

TIME = np.linspace(0.0, 1.0, 101)
PUSH = np.sin(9.0 * TIME)
JOINT = ("base", "coupon")
MODEL = """\
model: 1
title: Appendix A
masses: {coupon: 1 kg}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 0.01 N/m}
  - {kind: gap, between: [base, coupon], stiffness: 10 N/m, clearance: 0.5 m}
  - {kind: damper, between: [base, coupon], damping: 0.0632455532 N s/m}
excitation: {force on: coupon}
sensors: {acc: {at: coupon, measures: acceleration}}
"""


def model(*effects, force=False, between=JOINT):
    excitation = Excitation("force", "coupon") if force else Excitation("base acceleration")
    elements = [Element(Spring(0.01), JOINT), *(Element(e, between) for e in effects)]
    return Model("t", {"coupon": 2.0}, tuple(elements), excitation)


def test_play_is_a_table_of_straight_lines_and_exact():
    deck = deck_of_model(model(Gap(10.0, 0.5)), TIME, PUSH)
    (bush,) = deck.springs
    z = np.linspace(-1.0, 1.0, 401)
    by_hand = 0.01 * z + 10.0 * np.sign(z) * np.maximum(np.abs(z) - 0.5, 0.0)
    assert_allclose(np.interp(z, bush.displacement, bush.force), by_hand, atol=1e-12)
    assert bush.displacement.size == 4
    assert bush.stiffness == 0.01


def test_a_base_that_moves_becomes_forces_on_the_masses_and_a_force_stays_one():
    assert_allclose(deck_of_model(model(), TIME, PUSH).forces["coupon"], -2.0 * PUSH)
    forced = deck_of_model(model(force=True), TIME, PUSH)
    assert_allclose(forced.forces["coupon"], PUSH)


def test_a_joint_written_the_other_way_round_pushes_the_other_way():
    turned = model(Stop(10.0, 0.5, "positive"), between=("coupon", "base"))
    (bush,) = deck_of_model(turned, TIME, PUSH).springs
    # coupon to base: the stop is met where the coupon moves to the negative side
    assert_allclose(np.interp([-0.9, 0.9], bush.displacement, bush.force), [-4.009, 0.009])


def test_a_jump_stands_twice_at_its_place():
    (bush,) = deck_of_model(model(JumpGap(10.0, 0.5)), TIME, PUSH).springs
    twice = np.flatnonzero(np.diff(bush.displacement) == 0.0)
    assert_allclose(bush.displacement[twice], [-0.5, 0.5])
    assert_allclose(bush.force[twice + 1] - bush.force[twice], 5.0, rtol=1e-6)


def test_a_curved_law_needs_a_range():
    with pytest.raises(ModelError, match=r"cubic_stiffness between base and coupon: .*--reach"):
        deck_of_model(model(CubicStiffness(10.0)), TIME, PUSH)
    (bush,) = deck_of_model(model(CubicStiffness(10.0)), TIME, PUSH, reach=2.0).springs
    z = np.linspace(-2.0, 2.0, 777)
    by_hand = 0.01 * z + 10.0 * z**3
    assert_allclose(np.interp(z, bush.displacement, bush.force), by_hand, atol=1e-6 * 80)


@pytest.mark.parametrize(
    ("effect", "why"),
    [
        (CoulombFriction(1.0), "depends on velocity"),
        (BoucWen(10.0, 0.1, 1.0), "depends on what was before"),
    ],
)
def test_what_no_table_holds_is_refused_in_one_line_naming_the_element(effect, why):
    wrong = f"elements.2: {effect.kind} between base and coupon: its force {why}"
    with pytest.raises(ModelError, match=wrong) as error:
        deck_of_model(model(effect), TIME, PUSH)
    assert "\n" not in str(error.value)


def test_every_kind_of_effect_is_known_to_be_held_or_refused():
    assert {"spring", "damper", "gap", "attached_mode"} < set(EFFECTS)


def test_an_attached_mode_is_a_node_of_its_own():
    mode = AttachedMode(0.1, 20.0, 0.01)
    deck = deck_of_model(model(mode, Damper(damping_ratio=0.5)), TIME, PUSH)
    assert list(deck.masses.values()) == [2.0, 0.1]
    name = list(deck.masses)[1]
    assert_allclose(deck.springs[1].stiffness, 0.1 * (2 * np.pi * 20.0) ** 2)
    assert ("coupon", name) == deck.springs[1].between
    assert_allclose([d[2] for d in deck.dampers][1], 2 * 0.5 * np.sqrt(0.01 * 2.0))
    assert set(deck.forces) == {"coupon", name}  # the base moves under both
    ends = [c[3:5] for c in cards_of(transient_deck(deck)) if c[0] == "CBUSH"]
    assert ends == [["1", "2"], ["2", "3"]]


def test_an_unknown_mass_is_refused():
    with pytest.raises(ModelError, match="no mass 'rim'; the model has coupon"):
        check_places(model(), ["rim"])


def write(tmp_path, *options):
    path = tmp_path / "gap.yaml"
    path.write_text(MODEL)
    arguments = ["nastran", "write", str(path), "--out", str(tmp_path / "decks"), *options]
    return CliRunner().invoke(build_app(), arguments)


def test_a_study_is_a_deck_for_each_point(tmp_path):
    done = write(
        tmp_path, "--level", "5 N", "--length-s", "3", "--velocity", "coupon=4 m/s",
        "--vary", "gap.clearance=0.1 m, 250 mm", "--vary", "masses.coupon=1 kg,2 kg",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    with (tmp_path / "decks" / "decks.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    assert [row["elements.gap.clearance"] for row in rows] == ["0.1 m"] * 2 + ["250 mm"] * 2
    for row, (clearance, mass) in zip(
        rows, [(0.1, 1.0), (0.1, 2.0), (0.25, 1.0), (0.25, 2.0)], strict=True
    ):
        deck = tmp_path / "decks" / row["deck"]
        cards = cards_of(deck.read_text())
        table = next(c for c in cards if c[0] == "TABLED1")
        assert_allclose(float(table[11]), -clearance, rtol=1e-9)
        assert float(next(c for c in cards if c[0] == "CONM2")[4]) == mass
        time, force, _ = forces_of_deck(deck)[2]
        # linear sweep from 0 to 30 Hz in 3 s, by hand
        assert_allclose(force, 5.0 * np.cos(2 * np.pi * 5.0 * time**2), atol=1e-7)
        assert float(next(c for c in cards if c[0] == "TIC")[5]) == 4.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "give an amplitude"),
        (("--level", "5 m"), "N"),
        (("--level", "5 N", "--to-hz", "600"), "must be more than twice 600 Hz"),
        (("--level", "5 N", "--vary", "gap.clearance"), "expected a place and values"),
        (("--level", "5 N", "--vary", "gap.width=1 m"), "no parameter of gap 'width'"),
        (("--level", "5 N", "--spacing", "octaves"), "octaves need"),
        (("--level", "5 N", "--velocity", "coupon=4 N"), "m/s"),
    ],
)
def test_wrong_options_are_told(tmp_path, options, message):
    done = write(tmp_path, *options)
    assert done.exit_code == 2
    assert message in " ".join(done.output.replace("│", " ").split())


def test_a_coupon_becomes_a_deck_of_shells(tmp_path):
    coupon = "configs/coupons/pom_c_radial.yaml"
    done = CliRunner().invoke(
        build_app(), ["nastran", "write", coupon, "--out", str(tmp_path), "--json", "-"]
    )
    assert done.exit_code == 0, done.output
    text = (tmp_path / "pom_c_radial.dat").read_text()
    assert text.startswith("SOL 103\nCEND\n")
    assert sum(c[0] == "CQUAD4" for c in cards_of(text)) == 1600


STUDY = """\
study: 1
title: decks
kind: grid
model: gap.yaml
run: {excitation: sine sweep, level: 5 N, from: 0 Hz, to: 30 Hz, duration: 3 s,
      sample rate: 1000 Hz, initial velocity: 4 m/s}
vary:
  - {name: a, set: elements.gap.clearance, values: [0.1 m, 0.25 m]}
  - {name: A, set: run.level, values: [1 N, 5 N]}
"""


def test_a_study_file_is_a_deck_for_each_of_its_points(tmp_path):
    (tmp_path / "gap.yaml").write_text(MODEL)
    (tmp_path / "study.yaml").write_text(STUDY)
    arguments = ["nastran", "write", str(tmp_path / "study.yaml"), "--out", str(tmp_path / "d")]
    done = CliRunner().invoke(build_app(), arguments)
    assert done.exit_code == 0, done.output
    with (tmp_path / "d" / "decks.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    points = [(a, level) for a in (0.1, 0.25) for level in (1.0, 5.0)]
    written = [(row["a"], row["A"]) for row in rows]
    assert written == [(f"{a:g} m", f"{f:g} N") for a, f in points]
    for row, (clearance, level) in zip(rows, points, strict=True):
        deck = tmp_path / "d" / row["deck"]
        cards = cards_of(deck.read_text())
        table = next(c for c in cards if c[0] == "TABLED1")
        assert_allclose(float(table[11]), -clearance, rtol=1e-9)
        time, force, _ = forces_of_deck(deck)[2]
        assert_allclose(force, level * np.cos(2 * np.pi * 5.0 * time**2), atol=1e-7)
        assert float(next(c for c in cards if c[0] == "TIC")[5]) == 4.0


@pytest.mark.parametrize("driven", ["base", "force"])
def test_a_test_of_a_log_shakes_the_deck(tmp_path, driven):
    """The table of forces is what the recording says, in newtons on the mass."""
    forced = driven == "force"
    rate, time = 1000.0, np.arange(2000) / 1000.0
    wave = 3.0 * np.sin(2.0 * np.pi * 7.0 * time)
    unit, role = ("N", "force") if forced else ("m/s^2", "control")
    channel = Channel("drive", unit, "drive", unit)
    write_tdms(tmp_path / "T1.tdms", recording_of_arrays("T1", [channel], wave[None], rate))
    (tmp_path / "log.yaml").write_text(
        "testlog: 1\nrecordings: .\n"
        f"channels: {{drive: {{role: {role}}}}}\nprocessing: {{crop: none}}\n"
        "tests: [{id: 1, recording: T1.tdms}]\n"
    )
    text = MODEL if forced else MODEL.replace("{force on: coupon}", "{base: acceleration}")
    (tmp_path / "gap.yaml").write_text(text.replace("coupon: 1 kg", "coupon: 2 kg"))
    arguments = [
        "nastran", "write", str(tmp_path / "gap.yaml"), "--out", str(tmp_path / "d"),
        "--log", str(tmp_path / "log.yaml"), "--test", "1",
    ]  # fmt: skip
    done = CliRunner().invoke(build_app(), arguments)
    assert done.exit_code == 0, done.output
    when, force, _ = forces_of_deck(tmp_path / "d" / "gap.dat")[2]
    assert_allclose(when, time, atol=1e-9)
    assert_allclose(force, wave if forced else -2.0 * wave, atol=1e-7)
