"""Effects of the user's own: loaded, tried, refused in one line, simulated, sent to workers."""

import json
import pickle
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from tests.in_process import run

from shakerproc.errors import ModelError
from shakerproc.model_files import EffectSource, effect_files, load_effects, used_effects
from shakerproc.models import BASE, EFFECTS, Element, Excitation, Model, own_effects
from shakerproc.models.effects import ContactDamping, Damper, Gap, Spring
from shakerproc.models.tabulated import AbstractSampledEffect, tables_of
from shakerproc.simulation import simulate

FILE = Path(__file__).parents[2] / "examples" / "my_effects.py"
TEXT = FILE.read_text(encoding="utf-8")
LAW = "self.force * np.sin(2.0 * np.pi * displacement / self.pitch)"


@pytest.fixture(autouse=True)
def _afterwards_unknown():
    yield
    effect_files.forget_effects()


@pytest.fixture
def detent():
    return load_effects(FILE)["detent"]


def test_a_file_of_effects_is_known_until_another_is_used(detent, tmp_path):
    assert EFFECTS["detent"] is detent
    assert "detent" in list(EFFECTS)
    other = tmp_path / "other.py"
    other.write_text(TEXT.replace('"detent"', '"other"'), encoding="utf-8")
    load_effects(other)
    assert "other" in EFFECTS
    assert "detent" not in EFFECTS


def one_mass(effect):
    elements = (Spring(1e5), Damper(damping=3.0), effect)
    return Model(
        "one mass",
        {"coupon": 0.1},
        tuple(Element(one, (BASE, "coupon")) for one in elements),
        Excitation("base acceleration"),
    )


def base(time):
    return 60.0 * np.sin(2.0 * np.pi * 140.0 * time)


def test_its_motion_is_that_of_another_integrator(detent):
    effect = detent(4.0, 1e-4)
    found = simulate(one_mass(effect), base, 5000.0, duration=0.2, growth=False)

    def rates(time, y):
        force = 1e5 * y[0] + 3.0 * y[1] + effect.force_at(y[:1], y[1:])[0]
        return [y[1], -force / 0.1 - base(time)]

    other = solve_ivp(
        rates, (0.0, 0.2), [0.0, 0.0], t_eval=found.time, rtol=1e-9, atol=1e-13, max_step=1e-3
    )
    size = np.max(np.abs(other.y[0]))
    assert size > 1e-4  # past the next place
    assert_allclose(found.displacement[0], other.y[0], atol=2e-3 * size)


@pytest.mark.parametrize(
    "known", [Gap(1e5, 5e-5), ContactDamping(20.0, 5e-5)], ids=lambda e: e.kind
)
def test_a_sampled_law_with_corners_or_jumps_moves_as_the_exact_one(known):
    class Sampled(AbstractSampledEffect):
        kind = "sampled"
        force_at = staticmethod(known.force_at)
        switches = staticmethod(known.switches)

    exact, sampled = (
        simulate(one_mass(effect), base, 5000.0, duration=0.2, growth=False)
        for effect in (known, Sampled())
    )
    size = np.max(np.abs(exact.displacement))
    assert_allclose(sampled.displacement, exact.displacement, atol=1e-6 * size)
    z, v = np.meshgrid(np.linspace(-2e-4, 2e-4, 201), np.linspace(-0.2, 0.3, 11))
    table = sum(one.value(z, v) for one in tables_of(Sampled()))
    assert_allclose(table, known.force_at(z, v), atol=1e-9)


def test_an_effect_takes_its_file_to_another_process(detent, monkeypatch):
    effect = detent(4.0, 1e-4)
    packed, source = pickle.dumps(one_mass(effect)), used_effects()
    assert isinstance(source, EffectSource)
    effect_files.forget_effects()
    monkeypatch.setattr(effect_files, "_MODULES", {})
    monkeypatch.delitem(sys.modules, type(effect).__module__)
    there = pickle.loads(packed).elements[-1].effect  # noqa: S301 - made above
    assert (there.kind, there.force, there.pitch) == ("detent", 4.0, 1e-4)
    assert type(there) is EFFECTS["detent"]
    assert used_effects() == source


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("x = 1", "mine.py: no effect in it. Write a class"),
        ("import nothing_of_that_name", "mine.py, line 1: ModuleNotFoundError"),
        ("def f(:", "mine.py, line 1: SyntaxError"),
        (TEXT.replace('"detent"', '"gap"'), "class Detent: kind 'gap' exists already"),
        (TEXT.replace('"detent"', '"a b"'), "must be one word"),
        (
            TEXT.replace('"pitch": Parameter', '"picth": Parameter'),
            "a Parameter for each field",
        ),
        (TEXT.replace(LAW, "np.sqrt(displacement)"), "not 2000 finite numbers"),
        (TEXT.replace(LAW, "1.0 / (np.abs(velocity) > 1.0)"), "not 2000 finite numbers"),
        (TEXT.replace(LAW, "np.log(2e-4 + displacement)"), "returns nan at displacement"),
        (TEXT.replace(LAW, "np.sign(displacement - 2e-5)"), r"jumps at displacement 2e-05 m"),
        (TEXT.replace(LAW, "np.sign(velocity)"), "Law.FRICTION"),
        (TEXT.replace(LAW, "float(displacement)"), r"class Detent, line 4\d: TypeError"),
        (TEXT.replace("def identification", "def unknown"), "neither example"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_in_one_line(text, match, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError, match=match) as refused:
        load_effects(path)
    assert "\n" not in str(refused.value)
    assert not EFFECTS.from_user


def test_no_text_or_no_file_is_refused(tmp_path):
    path = tmp_path / "mine.py"
    path.write_bytes(b"\xff\xfe\x00")
    for one in (path, tmp_path / "none.py"):
        with pytest.raises(ModelError, match="cannot be read"):
            load_effects(one)


def test_packages_bring_effects_by_entry_point(monkeypatch, tmp_path):
    (tmp_path / "brought_effects.py").write_text(TEXT, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    entry = EntryPoint("detent", "brought_effects:Detent", own_effects.GROUP)
    monkeypatch.setattr(own_effects, "entry_points", lambda *, group: [entry] * (group != ""))
    known = own_effects.EffectRegistry({"gap": Gap})
    assert list(known) == ["gap", "detent"]
    assert known["detent"].formula.startswith("F = Fd")
    broken = EntryPoint("broken", "brought_effects:Nothing", own_effects.GROUP)
    monkeypatch.setattr(own_effects, "entry_points", lambda *, group: [broken] * (group != ""))
    with pytest.raises(ModelError, match=r"entry point broken .*AttributeError"):
        list(own_effects.EffectRegistry({"gap": Gap}))


MODEL = """\
model: 1
title: toothed
masses: {coupon: 28.6 g}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 1.2e5 N/m}
  - {kind: damper, between: [base, coupon], damping: 1.5 N s/m}
  - {kind: detent, between: [base, coupon], force: 2 N, pitch: 0.2 mm}
excitation: {base: acceleration}
sensors: {ch3: {at: coupon}}
"""
LOG = """\
testlog: 1
channels: {control 1: {role: control}, response 1: {role: response, name: ch3, at: coupon}}
tests:
  - {id: 1, recording: one.tdms, excitation: random, level: 0.002 g^2/Hz,
     from: 20 Hz, to: 800 Hz}
"""


def test_the_commands_take_a_file_of_effects(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("toothed.yaml").write_text(MODEL, encoding="utf-8")
    Path("log.yaml").write_text(LOG, encoding="utf-8")
    own = ("--effects", FILE)
    assert run("effects", "detent", *own, "-o", "detent.png") == 0
    assert Path("detent.png").stat().st_size > 1000
    assert run("simulate", "toothed.yaml", "log.yaml", "--duration-s", "4", *own) == 0
    assert (
        run("compare", "toothed.yaml", "log.yaml", *own, "--no-figures", "--json", "c.json")
        == 0
    )
    document = json.loads(Path("c.json").read_text(encoding="utf-8"))
    assert list(document["effects_sha256"]) == ["my_effects.py"]
    effect_files.forget_effects()
    capsys.readouterr()
    assert run("compare", "toothed.yaml", "log.yaml") == 1
    assert 'unknown kind "detent"' in capsys.readouterr().err
