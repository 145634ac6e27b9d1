"""`sp.modes`, as a notebook uses it: the same as the command, with tables and figures."""

import json

import numpy as np
import pytest
from benchmarks.modal_signals import draw
from matplotlib.figure import Figure
from numpy.testing import assert_allclose
from tests.in_process import run
from tests.modal.test_command import LOG, write_csv

import shakerproc as sp


@pytest.fixture(scope="module")
def structure():
    return draw(np.random.default_rng(11), 4, noise_db=50.0, duration=10.0)


@pytest.fixture(scope="module")
def path(tmp_path_factory, structure):
    folder = tmp_path_factory.mktemp("modes")
    (folder / "recordings").mkdir()
    for number in (1, 2):
        write_csv(folder / "recordings" / f"{number}.csv", structure)
    line = "  - {{id: {0}, recording: {0}.csv, excitation: random, from: 3 Hz, to: 215 Hz}}\n"
    (folder / "log.yaml").write_text(LOG + line.format(1) + line.format(2))
    return folder / "log.yaml"


@pytest.fixture(scope="module")
def found(path):
    return sp.modes(sp.read_log(path), tests=[1])


def test_the_function_finds_what_the_command_writes(path, found, tmp_path):
    options = ("--test", "1", "--no-figures", "--json", tmp_path / "m.json")
    assert run("modal", path, *options, "--out", tmp_path / "out") == 0
    written, told = json.loads((tmp_path / "m.json").read_text()), found.as_json()
    assert written["tests"] == json.loads(json.dumps(told["tests"]))
    table = found.to_pandas()
    assert_allclose(
        table["frequency_hz"],
        [mode["frequency_hz"]["value"] for mode in written["tests"][0]["modes"]],
    )


def test_tables_and_figures(found, structure):
    assert_allclose(found.to_pandas()["frequency_hz"], structure.frequency, rtol=1e-3)
    assert len(found.shapes) == 4 * 8
    assert found.figures == tuple(
        f"test_1_{kind}" for kind in ("stabilisation", "synthesis", "shapes", "mac")
    )
    assert isinstance(found.plot("test_1_shapes"), Figure)
    with pytest.raises(sp.ArgumentError, match="no figure 'x'; there are test_1_stab"):
        found.plot("x")
    assert "frequency_hz" in found._repr_html_()


def test_residues_are_those_of_the_closed_form(found, structure):
    """Of an accelerance that is a sum of modes of unit mass: p²/(2i Im p) times both shapes."""
    for mode, f, zeta, shape in zip(
        found.as_json()["tests"][0]["modes"],
        structure.frequency,
        structure.damping,
        structure.shapes,
        strict=True,
    ):
        pole = 2.0 * np.pi * f * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
        wanted = pole**2 / (2j * pole.imag) * shape * shape[structure.driven[0]]
        residues = np.array(mode["residues"]["real"]) + 1j * np.array(
            mode["residues"]["imaginary"]
        )
        assert_allclose(residues[:, 0], wanted, atol=0.05 * np.abs(wanted).max())


def test_what_is_asked_for_goes_before_the_log(path, structure):
    log = sp.read_log(path)
    found = sp.modes(log, band=(50.0, 205.0), count=1)
    assert list(found.to_pandas()["test"]) == ["1", "2"]
    assert len(found.tracks) == 1
    assert found.to_pandas()["frequency_hz"].min() > 50.0
    with pytest.raises(sp.ArgumentError, match="band: expected from below to"):
        sp.modes(log, band=(5.0, 5.0))
    with pytest.raises(sp.ArgumentError, match="log: expected a test log"):
        sp.modes(path)
