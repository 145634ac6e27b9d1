"""Decks read back by a reader of their own, punch files from a writer of their own."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ExchangeError
from shakerproc.exchange.nastran_decks import (
    Bush,
    PlateDeck,
    TransientDeck,
    card,
    plate_deck,
    real16,
    transient_deck,
)
from shakerproc.exchange.nastran_punch import read_punch


def cards_of(text):
    """Read large-field cards back: a list of [name, field, ...]."""
    found = []
    for line in text.split("BEGIN BULK\n")[1].splitlines():
        if line.startswith(("$", "PARAM", "ENDDATA")):
            continue
        fields = [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
        if line[0] == "*":
            found[-1] += fields
        else:
            assert line[:8].strip().endswith("*")
            found.append([line[:8].strip(" *"), *fields])
    return found


def named(text, name):
    return [c for c in cards_of(text) if c[0] == name]


def table_of(text, identity):
    fields = next(c for c in named(text, "TABLED1") if c[1] == str(identity))[9:]
    numbers = [float(f) for f in fields[: fields.index("ENDT")]]
    return np.array(numbers).reshape(-1, 2).T


@pytest.fixture
def gap():
    """Appendix A: 1 kg on a gap of 0.5 m, cosine chirp of 5 N."""
    z = np.linspace(-3.0, 3.0, 601)
    time = np.linspace(0.0, 30.0, 3001)
    return TransientDeck(
        title="gap",
        masses={"mass": 1.0},
        springs=[
            Bush(("base", "mass"), 0.01, z, 10.0 * np.sign(z) * np.maximum(abs(z) - 0.5, 0))
        ],
        dampers=[("base", "mass", 0.0632455532)],
        time=time,
        forces={"mass": 5.0 * np.cos(0.5 * time**2)},
        initial_velocity={"mass": 4.0},
        steps=15000,
    )


def test_a_transient_deck_reads_back_to_nine_digits(gap):
    text = transient_deck(gap)
    assert text.startswith("SOL 400\nCEND\n")
    assert text.endswith("ENDDATA\n")
    assert_allclose(
        table_of(text, 102),
        [gap.springs[0].displacement, gap.springs[0].force],
        rtol=1e-9,
        atol=1e-15,
    )
    assert_allclose(table_of(text, 210), [gap.time, gap.forces["mass"]], rtol=1e-9, atol=1e-15)
    assert_allclose(float(named(text, "PVISC")[0][2]), 0.0632455532, rtol=1e-12)
    assert [c[1:5] for c in named(text, "CBUSH")] == [["2", "1", "1", "2"]]
    assert float(named(text, "TIC")[0][5]) == 4.0
    assert float(named(text, "NLSTEP")[0][2]) == 30.0
    assert max(map(len, text.splitlines())) <= 72


@pytest.mark.parametrize(
    "value", [0.0, -1.0, 1e-300, -1.23456789012345e-5, 6.02214076e23, 1 / 3]
)
def test_a_real_keeps_nine_digits_and_its_point(value):
    text = real16(value)
    assert len(text) <= 16
    assert "." in text
    assert_allclose(float(text), value, rtol=1e-9)


def test_a_word_too_long_for_its_field_is_refused():
    with pytest.raises(ValueError, match="does not fit a field of 16 columns"):
        card("PBUSH", "a word much too long")


def test_a_title_cannot_break_out_of_its_line(gap):
    text = transient_deck(
        TransientDeck(**{
            **{name: getattr(gap, name) for name in gap.__dataclass_fields__},
            "title": "x\nENDDATA\n$ §",
        })
    )
    assert text.count("\nENDDATA\n") == 1


def test_a_plate_deck_holds_the_mesh_of_the_plate():
    plate = PlateDeck("coupon", 8e-3, 50e-3, 2.6e-3, 2.8e9, 0.44, 1410.0)
    text = plate_deck(plate)
    assert len(named(text, "CQUAD4")) == 1600
    xyz = np.array([[float(v) for v in c[3:6]] for c in named(text, "GRID")])
    radius = np.hypot(xyz[:, 0], xyz[:, 1])
    assert_allclose([radius.min(), radius.max()], [8e-3, 50e-3], rtol=1e-9)
    quads = np.array([[int(v) for v in c[3:7]] for c in named(text, "CQUAD4")]) - 1
    x, y = xyz[quads, 0], xyz[quads, 1]
    area = 0.5 * np.abs(np.sum(x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1), axis=1)).sum()
    assert_allclose(area, np.pi * (50e-3**2 - 8e-3**2), rtol=2e-3)  # chords of 80 sides
    assert float(named(text, "MAT1")[0][4]) == 0.44
    assert len([c for c in named(text, "SPC1") if c[2] == "123456"]) == 80


def punch(tmp_path, *, sort=1, kind="real", steps=5, nodes=(1, 2)):
    """Write a punch file the way Nastran does; return it with the values in it."""
    rng = np.random.default_rng(3)
    values = rng.standard_normal((len(nodes), 6, steps))
    if kind == "complex":
        values = values + 1j * rng.standard_normal(values.shape)
    times = np.arange(steps) * 0.002
    write = by_step if sort == 1 else by_point
    lines = []
    for quantity in ("DISPLACEMENTS", "ACCELERATION"):
        output = "$REAL OUTPUT" if kind == "real" else "$REAL-IMAGINARY OUTPUT"
        head = ["$TITLE   =", "$SUBTITLE=", f"${quantity}", output, "$SUBCASE ID =  1"]
        lines += write(head, nodes, times, values)
    path = tmp_path / "results.pch"
    path.write_text("".join(f"{line:<72}{i:8d}\n" for i, line in enumerate(lines, 1)))
    return path, times, values


def by_step(head, nodes, times, values):
    word = "FREQUENCY" if np.iscomplexobj(values) else "TIME"
    for k, time in enumerate(times):
        yield from [*head, f"${word} ={time:16.7E}"]
        for i, node in enumerate(nodes):
            yield from result(f"{node:10d}       G", values[i, :, k])


def by_point(head, nodes, times, values):
    word = "FREQUENCY" if np.iscomplexobj(values) else "TIME"
    for i, node in enumerate(nodes):
        yield from [*head, f"$POINT ID ={node:12d}  IDENTIFIED BY {word}"]
        for k, time in enumerate(times):
            yield from result(f"{time:16.6E} G", values[i, :, k])


def result(lead, data):
    parts = np.concatenate([data.real, data.imag]) if np.iscomplexobj(data) else data
    for i, row in enumerate(parts.reshape(-1, 3)):
        yield f"{lead if i == 0 else '-CONT-':<18}" + "".join(f"{v:18.6E}" for v in row)


@pytest.mark.parametrize("sort", [1, 2])
@pytest.mark.parametrize("kind", ["real", "complex"])
def test_a_punch_file_comes_back_as_it_was_written(tmp_path, sort, kind):
    path, times, values = punch(tmp_path, sort=sort, kind=kind)
    tables = read_punch(path)
    assert [t.quantity for t in tables] == ["displacement", "acceleration"]
    assert tables[1].unit == "m/s^2"
    assert tables[0].abscissa == ("time" if kind == "real" else "frequency")
    for found in tables:
        assert found.points == (1, 2)
        assert_allclose(found.at, times, rtol=1e-6)
        assert_allclose(found.values, values, rtol=1e-6)


def test_every_cut_of_a_punch_file_is_refused_with_its_place(tmp_path):
    path, _, _ = punch(tmp_path)
    lines = path.read_text().splitlines(keepends=True)
    second = next(i for i, line in enumerate(lines) if line.startswith("$ACCELERATION"))
    heads = [i for i, line in enumerate(lines[:second]) if line.startswith("$TITLE")]
    for keep in range(10, len(lines)):
        if keep in heads:
            continue  # whole steps of one quantity alone: nothing tells that more was wanted
        path.write_text("".join(lines[:keep]))
        with pytest.raises(ExchangeError, match=r"results\.pch(:\d+)?: "):
            read_punch(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"results.pch: no displacements, velocities or accelerations"),
        ("hello world\n", r"results.pch:1: 'hello world' stands before any heading"),
        ("time,acc\n0,1\n", r"results.pch:1: 'time,acc' stands before any heading"),
    ],
)
def test_a_foreign_file_is_refused_with_its_line(tmp_path, text, message):
    path = tmp_path / "results.pch"
    path.write_text(text)
    with pytest.raises(ExchangeError, match=message):
        read_punch(path)


def test_a_damaged_number_is_refused_with_its_line(tmp_path):
    path, _, _ = punch(tmp_path)
    text = path.read_text().splitlines()
    text[6] = re.sub(r"E", "X", text[6])
    path.write_text("\n".join(text))
    with pytest.raises(ExchangeError, match=r"results.pch:7: a number is missing or cut off"):
        read_punch(path)


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "results.pch"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ExchangeError, match="not a punch file: byte 0"):
        read_punch(path)
