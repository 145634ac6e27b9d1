"""The command stiffness: tables, warnings and figures."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from shakerproc.cli import build_app


def stiffness(*arguments):
    return CliRunner().invoke(build_app(), ["stiffness", *map(str, arguments)])


def pull(folder, stiffnesses):
    """Write a run for each stiffness [N/mm], with a little noise."""
    folder.mkdir()
    for number, k in enumerate(stiffnesses, 1):
        x = np.linspace(0.0, 0.2, 300)
        noise = 0.1 * np.random.default_rng(number).standard_normal(300)
        rows = [f"{a:.6f},{f:.4f}" for a, f in zip(x, k * x + noise, strict=True)]
        (folder / f"run{number}.csv").write_text("\n".join(["displacement_mm,force_n", *rows]))
    return folder


@pytest.mark.shared
def test_the_reference_is_printed_and_drawn(shared, tmp_path):
    runs = [shared / "reference/recordings" / f"tensile_run{i}.csv" for i in range(1, 7)]
    done = stiffness(*runs, "--out", tmp_path, "--json", tmp_path / "x.json")
    assert done.exit_code == 0, done.output
    expected = json.loads((shared / "reference/thesis/tensile/tensile.json").read_text())
    (found,) = json.loads((tmp_path / "x.json").read_text())["specimens"]
    assert_allclose(found["k_thesis_n_per_m"] / 1e3, expected["k_est_n_per_mm"], rtol=1e-12)
    assert "the last runs still stiffen" in done.output
    assert {"all_runs.png", "last_runs.png"} < {path.name for path in tmp_path.iterdir()}


def test_steady_runs_of_different_joints_give_no_warning(tmp_path):
    soft, stiff = (
        pull(tmp_path / "soft", [2000, 2010, 1990]),
        pull(tmp_path / "stiff", [4000] * 3),
    )
    done = stiffness(soft, stiff, "--out", tmp_path / "out", "--no-figures")
    assert done.exit_code == 0, done.output
    assert "warning" not in done.output
    assert "stiff: k = " in done.output


def test_specimens_all_alike_are_suspicious(tmp_path):
    one = pull(tmp_path / "steel", [2670, 2650, 2690])
    other = pull(tmp_path / "plastic", [2675, 2655, 2685])
    done = stiffness(one, other, "--out", tmp_path / "out", "--no-figures")
    assert "may have measured the grips" in done.output


def test_a_folder_is_taken_in_the_order_of_its_numbers(tmp_path):
    folder = pull(tmp_path / "many", [1000 + 100 * i for i in range(11)])
    done = stiffness(
        folder, "--last", 2, "--force-n", 150, "--out", tmp_path, "--json", "-", "--no-figures"
    )
    document = json.loads(done.stdout)
    assert document["specimens"][0]["runs"][-2:] == ["run10", "run11"]
    assert_allclose(document["specimens"][0]["k_thesis_n_per_m"], 1.95e6, rtol=5e-3)


@pytest.mark.parametrize(
    ("options", "status", "message"),
    [
        (("--last", 4), 1, "the last 4 were wanted"),
        (("--sample", 999), 1, "a secant was wanted at 999"),
        (("--force-n", 1e6), 1, "the secant asks for"),
        (("--from-share", 0.9), 2, "must lie between 0 and"),
    ],
)
def test_what_the_runs_do_not_hold_is_told(tmp_path, options, status, message):
    folder = pull(tmp_path / "one", [2000] * 3)
    done = stiffness(folder, "--out", tmp_path / "out", *options)
    assert done.exit_code == status
    said = f"{done.output} {done.exception}".replace("│", " ")
    assert message in " ".join(said.split())


def test_an_empty_folder_is_told(tmp_path):
    done = stiffness(tmp_path)
    assert done.exit_code == 1
    assert "no tensile runs" in str(done.exception)
