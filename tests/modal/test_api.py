"""`sp.modes`, as a notebook uses it: the same as the command, with tables and figures."""

import json
import re
from base64 import b64decode
from xml.dom import minidom

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
    nodes = "".join(f"    {i}: [{100 * i} mm, 0 mm, 0 mm]\n" for i in range(1, 10))
    geometry = (
        f"geometry:\n  nodes:\n{nodes}  lines: [[1, 2, 3, 4, 5, 6, 7, 8], [8, 9]]\ntests:\n"
    )
    line = "  - {{id: {0}, recording: {0}.csv, excitation: random, from: 3 Hz, to: 215 Hz}}\n"
    log = LOG.replace("tests:\n", geometry)
    (folder / "log.yaml").write_text(log + line.format(1) + line.format(2))
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


def test_a_notebook_shows_a_shape_swinging_on_the_geometry(found):
    """The picture is an SVG of its own; its largest is that of the phase at which it begins."""
    shown = found.shape(2)._repr_html_()
    picture = b64decode(re.search(r"base64,([^\"]+)", shown)[1])
    minidom.parseString(picture)  # noqa: S318 - ours
    svg = picture.decode()
    swings = re.findall(r'<path class="(\w+)" d="([^"]*)"><animate [^>]*values="([^"]*)"', svg)
    assert [(css, values.count(";") + 1) for css, _, values in swings] == [
        ("c0", 17),
        ("d0", 17),
    ]
    rest = re.search(r'<path class="rest" d="([^"]*)"', svg)[1]
    assert (swings[0][1].count("M"), rest.count("M")) == (7, 8)  # nobody measures node 9
    found.shape(2).plot()._repr_png_()
    assert any("1 of 9 nodes have no sensor" in note for note in found.found.tests[0].notes)
    with pytest.raises(sp.ArgumentError, match="mode"):
        found.shape(99)
