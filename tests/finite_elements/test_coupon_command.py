"""The command modes and its coupon files: what it says, writes and refuses."""

import json
import shutil
from pathlib import Path

import pytest
from numpy.testing import assert_allclose
from tests.docs import console
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.errors import DocumentError
from shakerproc.model_files import read_model
from shakerproc.model_files.coupon_files import read_coupon
from shakerproc.simulation.harmonic_balance import natural_frequencies
from shakerproc.simulation.harmonic_balance.system import system_of_model

COUPONS = "configs/coupons"


def modes(*arguments):
    return CliRunner().invoke(build_app(), ["coupon", *map(str, arguments)])


@pytest.fixture(scope="module")
def worked(tmp_path_factory):
    """POM C, with everything that the command can write."""
    folder = tmp_path_factory.mktemp("modes")
    done = modes(
        f"{COUPONS}/pom_c_radial.yaml", "--count", 3, "--out", folder / "out",
        "--json", folder / "result.json", "--model", folder / "model.yaml",
        "--temperature-c", -30,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    return folder, done, json.loads((folder / "result.json").read_text())


@pytest.mark.slow
def test_the_table_stands_beside_the_thesis_and_says_what_was_inferred(worked):
    _, done, document = worked
    assert "clamped radius 8.00 mm (inferred: it was fitted" in done.output
    assert "at 8.35 mm, which the documents state" in done.output
    assert document["clamp"]["inferred"] is True
    by_name = {(m["diameters"], m["circles"]): m for m in document["modes"]}
    for name, published in {(1, 0): 314.0, (0, 0): 364.0, (2, 0): 410.0}.items():
        assert by_name[name]["published_hz"] == published
        assert abs(by_name[name]["deviation_percent"]["shell mesh"]) < 0.5
    stated = {(m["diameters"], m["circles"]): m for m in document["modes_at_stated_radius"]}
    # MYSTRAN at 8.35 mm, measured before the project began
    assert_allclose(stated[1, 0]["frequency_hz"]["shell mesh"], 321.77, rtol=2e-3)


@pytest.mark.slow
def test_the_page_of_the_thesis_shows_what_is_printed(worked):
    """The options of `worked` add lines, and change none of those on the page."""
    page = Path("docs/thesis.md").read_text(encoding="utf-8")
    ((command,),) = [content for what, _, content in console.blocks(page) if what == "console"]
    assert command.line == f"shakerproc coupon {COUPONS}/pom_c_radial.yaml"
    assert console.disagreement(command.expected, worked[1].stdout) is None


@pytest.mark.slow
def test_the_stiffness_comes_with_its_spread_and_meshes(worked):
    _, done, document = worked
    (hole,) = document["stiffness"]
    assert abs(hole["deviation_percent"]) < 5.0
    assert len(hole["mesh_convergence"]) == 3
    assert "the laws spread from" in done.output


@pytest.mark.slow
def test_the_joint_closes_in_the_cold(worked):
    _, _, document = worked
    # by hand: 9.8 mm and 50 K of the difference between 110e-6 and 12e-6
    assert_allclose(document["play"][0]["play_m"], -9.8e-3 * 50.0 * 98e-6, rtol=1e-9)


@pytest.mark.slow
def test_figures_and_tables_are_written(worked):
    folder, _, _ = worked
    written = {path.name for path in (folder / "out").iterdir()}
    assert written == {
        "modes.csv", "modes.json", "stiffness.csv", "mode_shapes.png", "clamped_radius.png",
        "manifest.json",
    }  # fmt: skip


@pytest.mark.slow
def test_the_model_rings_at_the_mode_that_a_table_drives(worked):
    folder, _, document = worked
    model = read_model(folder / "model.yaml")
    expected = next(m for m in document["modes"] if m["diameters"] == 0)
    (found,) = natural_frequencies(system_of_model(model, 1.0))
    assert_allclose(found, expected["frequency_hz"]["Mindlin"], rtol=1e-6)
    assert 0.5 * 28.5e-3 < model.masses["coupon"] < 28.5e-3
    assert "modes without nodal diameters" in (folder / "model.yaml").read_text()


def test_the_model_in_plane_rings_at_the_joint_frequency(tmp_path):
    done = modes(
        f"{COUPONS}/s355_slot.yaml", "--count", 1, "--out", tmp_path, "--no-figures",
        "--no-static", "--in-plane", "--model", tmp_path / "model.yaml", "--law", "traction",
        "--plane", "stress",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    model = read_model(tmp_path / "model.yaml")
    (found,) = natural_frequencies(system_of_model(model, 1.0))
    assert_allclose(found, 9509.0, rtol=0.1)  # table 6.4, whatever the load law


def test_every_coupon_of_the_thesis_is_read():
    for name in ("pom_c_radial", "s355_radial", "pom_c_slot", "s355_slot"):
        described = read_coupon_of(name)
        assert described.inferred
        assert described.fit is not None
    assert_allclose(read_coupon_of("s355_radial").coupon.mass, 0.3053, rtol=1e-3)
    assert_allclose(read_coupon_of("pom_c_radial").static.mass, 0.0548, rtol=2e-3)


def read_coupon_of(name):
    return read_coupon(Path(COUPONS) / f"{name}.yaml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "material: POM C",
            "material: POMC",
            r':\d+:\d+: material: no material "POMC" .*POM C',
        ),
        ("../materials.yaml", "none.yaml", r"materials: there is no file none\.yaml"),
        ("hole: {diameter: 9.8 mm}", "hole: {length: 9 mm}", r"expected diameter alone"),
        (
            "hole: {diameter: 9.8 mm}",
            "hole: {length: 8 mm, width: 9 mm}",
            r"at least the width",
        ),
        ("radius: 8.00 mm", "radius: 80 mm", r"outer_radius must exceed"),
        ("thickness: 2.6 mm", "thickness: 2.6", r"thickness: expected a number with a unit"),
        ("held: shell nodes", "held: nodes", r"held: expected"),
        ("outer_radius", "outer_radios", r'unknown key "outer_radios"; did you mean'),
    ],
)
def test_a_wrong_coupon_file_is_refused_with_its_place(tmp_path, old, new, message):
    shutil.copy("configs/materials.yaml", tmp_path / "materials.yaml")
    folder = tmp_path / "coupons"
    folder.mkdir()
    with open(f"{COUPONS}/pom_c_radial.yaml", encoding="utf-8") as file:  # noqa: PTH123
        text = file.read()
    assert old in text
    (folder / "x.yaml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(DocumentError, match=message):
        read_coupon(folder / "x.yaml")


def test_a_model_without_damping_is_refused(tmp_path):
    text = Path(f"{COUPONS}/pom_c_radial.yaml").read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not line.startswith("damping_ratio")]
    materials = Path("configs/materials.yaml").resolve().as_posix()
    path = tmp_path / "x.yaml"
    path.write_text("\n".join(kept).replace("../materials.yaml", materials), encoding="utf-8")
    done = modes(path, "--model", tmp_path / "m.yaml")
    assert done.exit_code == 2
    assert "has no damping_ratio" in " ".join(done.output.replace("│", " ").split())
