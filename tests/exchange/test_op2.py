"""Modes of OP2 files: one that pyNastran wrote, and tables written here word by word."""

import struct
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import completed

from shakerproc.errors import ExchangeError
from shakerproc.exchange.mode_files import read_mode_file
from shakerproc.exchange.nastran_op2 import read_op2

BY_PYNASTRAN = Path(__file__).parent / "nastran" / "modes.op2"
FREQUENCIES = np.array([0.0, 31.25, 62.5, 180.125])
MODE, NODE, COMPONENT = np.meshgrid(np.arange(4), np.arange(3), np.arange(6), indexing="ij")
SHAPES = np.cos(1.0 + MODE + 2.0 * NODE + 0.5 * COMPONENT)  # (modes, nodes, components)
NODES = (1, 2, 7)


def test_modes_that_pynastran_wrote_are_read():
    """Of the points with six directions: the scalar point 90 of the file has none."""
    found = read_op2(BY_PYNASTRAN)
    assert found.nodes == NODES
    assert_allclose(found.frequencies, FREQUENCIES, rtol=1e-6)
    assert_allclose(found.shapes, np.moveaxis(SHAPES, 0, -1), atol=1e-7)
    table = read_mode_file(BY_PYNASTRAN)
    assert table.places[:2] == ("1/x", "1/y")
    assert table.places[-1] == "7/about z"


def block(content, order="<"):
    marker = struct.pack(f"{order}i", len(content))
    return marker + content + marker


def keys(order, *values):
    return b"".join(block(struct.pack(f"{order}i", value), order) for value in values)


def announced(content, order="<"):
    """A block, and before it how many words it has."""
    return keys(order, len(content) // 4) + block(content, order)


def table(name, records, order="<"):
    """A table of records, each given by its blocks."""
    out = announced(name.ljust(8).encode(), order) + keys(order, -1)
    out += announced(b"\0" * 28, order) + keys(order, -2, 1, 0)
    out += announced(name.ljust(8).encode() + b"\0" * 20, order)
    number = -3
    for record in records:
        out += keys(order, number, 1, 0) + b"".join(announced(one, order) for one in record)
        number -= 1
    return out + keys(order, number, 1, 0, 0)


def ident(order, mode, eigenvalue, *, analysis=2, sort=0, wide=8, case=1):
    words = [analysis * 10 + 2, sort * 1000 + 7, 0, case, mode]
    head = struct.pack(f"{order}5if", *words, eigenvalue) + b"\0" * 12
    return (head + struct.pack(f"{order}i", wide)).ljust(200, b"\0").ljust(584)


def entries(order, shape):
    rows = zip(NODES, shape, strict=True)
    return b"".join(struct.pack(f"{order}2i6f", 10 * n + 2, 1, *v) for n, v in rows)


def shapes_of(order="<", **said):
    values = (2.0 * np.pi * FREQUENCIES) ** 2
    return [
        part
        for mode, (value, shape) in enumerate(zip(values, SHAPES, strict=True), 1)
        for part in ([ident(order, mode, value, **said)], [entries(order, shape)])
    ]


def lama(order, masses):
    rows = b"".join(
        struct.pack(f"{order}2i5f", mode, mode, 1.0, 1.0, 1.0, mass, 1.0)
        for mode, mass in enumerate(masses, 1)
    )
    return table("LAMA", [[ident(order, 0, 0.0)], [rows]], order)


def geometry(order):
    grids = [(1, 0, 0.1, 0.2, 0.3, 0), (2, 0, 1.0, 2.0, 3.0, 5), (7, 4, 1.0, 1.0, 1.0, 0)]
    cards = b"".join(struct.pack(f"{order}2i3f3i", *one, 0, 0) for one in grids)
    return table("GEOM1", [[struct.pack(f"{order}3i", 4501, 45, 1) + cards]], order)


def op2(*tables, order="<"):
    head = announced(b"\0" * 12, order) + announced(b"NASTRAN FORT TAPE ID CODE - ", order)
    head += announced(b"XXXXXXXX", order) + keys(order, -1, 0)
    return head + b"".join(tables) + keys(order, 0)


def written(folder, content):
    path = folder / "modes.op2"
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("order", ["<", ">"])
def test_shapes_have_unit_mass_and_nodes_their_places(tmp_path, order):
    """Generalised masses scale; a record may come in pieces, and other tables between."""
    parts = shapes_of(order)
    parts[1] = [parts[1][0][:32], parts[1][0][32:]]
    other = table("OES1X1", [[b"\1" * 584], [b"\2" * 400]], order)
    eigenvectors = table("OUGV1", parts, order)
    content = op2(geometry(order), lama(order, [1.0, 4.0, 1.0, 0.25]), other, eigenvectors,
                  order=order)  # fmt: skip
    found = read_op2(written(tmp_path, content))
    assert_allclose(found.frequencies, FREQUENCIES, rtol=1e-6)
    scale = np.array([1.0, 0.5, 1.0, 2.0])
    assert_allclose(found.shapes, np.moveaxis(SHAPES, 0, -1) * scale, atol=1e-6)
    assert list(found.positions) == [1]  # 2 has axes, 7 a place of its own
    assert_allclose(found.positions[1], (0.1, 0.2, 0.3), rtol=1e-6)


def test_axes_of_the_whole_structure_come_first(tmp_path):
    turned = [[part[0]] if len(part[0]) == 584 else [entries("<", -SHAPES[0])] for part in
              shapes_of()]  # fmt: skip
    content = op2(table("OUGV1", turned), table("BOUGV1", shapes_of()))
    assert_allclose(read_op2(written(tmp_path, content)).shapes[:, :, 0], SHAPES[0], atol=1e-7)


def test_a_file_that_is_cut_anywhere_is_one_line(tmp_path):
    content = op2(lama("<", [1.0] * 4), table("OUGV1", shapes_of()))
    whole = read_op2(written(tmp_path, content))
    assert whole.shapes.shape == (3, 6, 4)
    for length in [0, 1, 3, 4, *range(5, len(content), 37), len(content) - 1]:
        with pytest.raises(ExchangeError, match=r"^modes\.op2: ") as caught:
            read_op2(written(tmp_path, content[:length]))
        assert "\n" not in str(caught.value)


def test_a_flipped_byte_is_read_or_refused(tmp_path):
    """Nothing else is raised; of the keys and lengths none passes unseen."""
    content = op2(table("OUGV1", shapes_of()))
    refused = 0
    for at in range(0, len(content), 7):
        changed = bytearray(content)
        changed[at] ^= 0x81
        try:
            read_op2(written(tmp_path, bytes(changed)))
        except ExchangeError:
            refused += 1
    assert refused > 50


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no OP2 of Nastran"),
        (b"not an op2 file at all", "does not begin with a record of one word"),
        (struct.pack("<iqi", 8, 3, 8), "words of 8 bytes"),
        (op2(table("OES1X1", [[b"\1" * 584]])), r"no eigenvectors; ask for them with VECTOR"),
        (op2(table("OUGV1", shapes_of(analysis=9, wide=14))), "complex modes"),
        (op2(table("OUGV1", shapes_of(analysis=1))), "no real eigenvectors"),
        (op2(table("OUGV1", shapes_of(sort=1))), "not in rows of real points"),
        (op2(table("OUGV1", shapes_of() + shapes_of(case=2))), "modes of subcases 1, 2"),
        (op2(table("OUGV1", shapes_of()[:-1])), "is named and does not follow"),
        (op2(lama("<", [1.0, 0.0]), table("OUGV1", shapes_of())), "mode 2 has a generalised"),
        (op2().replace(b"NASTRAN FORT", b"SOMETHING EL"), "no OP2 of Nastran"),
    ],
)
def test_what_cannot_be_used_is_one_line(tmp_path, content, said):
    with pytest.raises(ExchangeError, match=said) as caught:
        read_op2(written(tmp_path, content))
    assert "\n" not in str(caught.value)


def test_convert_writes_them_and_asks_for_the_units(tmp_path):
    asked = completed("convert", BY_PYNASTRAN, tmp_path / "a.csv")
    assert asked.returncode == 2
    assert "does not say for which unit of mass its shapes are normalised" in asked.stderr
    told = completed("convert", BY_PYNASTRAN, tmp_path / "a.csv", "--mass-unit", "t")
    assert told.returncode == 0, told.stderr
    found = read_mode_file(tmp_path / "a.csv")
    row = found.row_of["2/z"]
    assert_allclose(found.shapes[row], SHAPES[:, 1, 2] / np.sqrt(1000.0), rtol=1e-5)
