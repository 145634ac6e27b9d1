"""Ways in which a file goes wrong."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from tests.fuzz.seeds import Seed

EXTREMES = [
    struct.pack("<I", value) for value in (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
] + [struct.pack("<Q", value) for value in (0, 2**31, 2**63 - 1, 2**64 - 1)]
PAYLOAD_FLIPS = 150
OTHER_FLIPS = 5000
OTHER_EXTREMES = 1500
WORDS = ("OVL", "inf", "-inf", "nan", "NaN", "1,5", "1.5", "", "1e999", "--", "1 2", "0x1F",
         "#REF!", '"1.5"', "1_0", "+", "1e", "\0", "\u00fc")  # fmt: skip
LINES = ("", "   ", "t [s],ch1 [g],ch2 [g]", "OVL", "0.01", "1;2;3", "1,2,3,4,5,6", "# note",
         "\0\0\0", "\u00fcberlast", '"', "nan,nan,nan", ",,", "\t\t", "-1")  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """A file that went wrong.

    Attributes
    ----------
    kind : str
        In which way.
    seed : Seed
        What it was.
    content : bytes
        What it is.
    index : bytes, optional
        What stands beside it as ``.tdms_index``.
    while_open : bytes, optional
        What the file becomes once it has been opened.
    skip : bool
        Whether the log asks for bad rows to be skipped.
    rows : int
        Rows of the original that are changed on purpose, at most; -1 where that is not known.
    """

    kind: str
    seed: Seed
    content: bytes
    index: bytes | None = None
    while_open: bytes | None = None
    skip: bool = False
    rows: int = -1


def mutants(seed: Seed) -> Iterator[Mutant]:
    """Every mutant of a seed, always in the same order."""
    yield from truncated(seed)
    yield from zeroed(seed)
    yield from extended(seed)
    if seed.name.endswith(".tdms"):
        yield from flipped_metadata(seed)
        yield from extremes(seed)
        yield from beside_an_index(seed)
        yield from changed_while_open(seed)
    else:
        yield from other_extremes(seed)
    if seed.table is not None:
        for change in (lines_changed, cells_changed):
            for mutant in change(seed):
                yield mutant
                yield replace(mutant, skip=True, kind=f"{mutant.kind}, skipped")
        yield from rewritten(seed)
    yield from flipped_payload(seed)


def truncated(seed: Seed) -> Iterator[Mutant]:
    for size in range(len(seed.content)):
        yield Mutant("truncate at every byte", seed, seed.content[:size])


def zeroed(seed: Seed) -> Iterator[Mutant]:
    n = len(seed.content)
    for size in range(n):
        yield Mutant("zeroed tail at every byte", seed, seed.content[:size] + bytes(n - size))


def extended(seed: Seed) -> Iterator[Mutant]:
    rng = np.random.default_rng(1)
    for size in (1, 3, 27, 28, 29, 512, 4096):
        yield Mutant("something appended", seed, seed.content + bytes(size))
        yield Mutant("something appended", seed, seed.content + rng.bytes(size))
    yield Mutant("something appended", seed, seed.content + seed.content)


def flip(content: bytes, at: int, bit: int) -> bytes:
    changed = bytearray(content)
    changed[at] ^= 1 << bit
    return bytes(changed)


def flipped_metadata(seed: Seed) -> Iterator[Mutant]:
    for part in seed.metadata:
        for at in part:
            for bit in range(8):
                yield Mutant("every metadata bit flipped", seed, flip(seed.content, at, bit))


def extremes(seed: Seed) -> Iterator[Mutant]:
    for part in seed.metadata:
        for at in part:
            for value in EXTREMES:
                if at + len(value) <= part.stop:
                    content = seed.content[:at] + value + seed.content[at + len(value) :]
                    yield Mutant("32/64-bit fields set to extremes", seed, content)


def flipped_payload(seed: Seed) -> Iterator[Mutant]:
    rng = np.random.default_rng(2)
    metadata = {at for part in seed.metadata for at in part}
    payload = [at for at in range(len(seed.content)) if at not in metadata]
    count = PAYLOAD_FLIPS if seed.metadata else OTHER_FLIPS
    for at in rng.choice(payload, count):
        content = flip(seed.content, int(at), int(rng.integers(8)))
        yield Mutant("payload bits flipped" if seed.metadata else "bits flipped", seed, content)


def beside_an_index(seed: Seed) -> Iterator[Mutant]:
    index = seed.content.replace(b"TDSm", b"TDSh")
    for size in (0, 1, 28, 100, len(index) // 2, len(index)):
        yield Mutant("stale, foreign or empty index", seed, seed.content, index[:size])
    yield Mutant("stale, foreign or empty index", seed, seed.content, b"\0" * 500)


def changed_while_open(seed: Seed) -> Iterator[Mutant]:
    n = len(seed.content)
    for size in (0, 1, n // 3, n // 2, n - 1):
        cut = seed.content[:size]
        yield Mutant("shrinks or grows while open", seed, seed.content, while_open=cut)
    longer = seed.content + seed.content
    yield Mutant("shrinks or grows while open", seed, seed.content, while_open=longer)


def other_extremes(seed: Seed) -> Iterator[Mutant]:
    """Extremes in the fields of formats whose fields are not known here."""
    rng = np.random.default_rng(3)
    for at in rng.choice(len(seed.content) - 8, OTHER_EXTREMES):
        value = EXTREMES[int(rng.integers(len(EXTREMES)))]
        content = seed.content[:at] + value + seed.content[at + len(value) :]
        yield Mutant("32/64-bit fields set to extremes", seed, content)


def lines_changed(seed: Seed) -> Iterator[Mutant]:
    """Rows that are gone, doubled, exchanged, or have something between them."""
    lines, table = seed.content.split(b"\n"), seed.table
    head = lines[: table.start]
    for at in table:
        before, line, after = lines[:at], lines[at], lines[at + 1 :]

        def mutant(kind: str, middle: list[bytes], rows: int = 1) -> Mutant:
            content = b"\n".join([*before, *middle, *after])  # noqa: B023
            return Mutant(kind, seed, content, rows=rows)

        yield mutant("row deleted", [])
        yield mutant("row doubled", [line, line])
        yield mutant("headers repeated", [*head, line])
        for text in LINES:
            yield mutant("line put in", [text.encode(), line])
            yield mutant("row replaced by a line", [text.encode()])
        sign = seed.delimiter.encode()
        for other in (b";", b",", b"\t", b" ", b"|", sign * 2):
            yield mutant("delimiters exchanged", [line.replace(sign, other)])
        cells = line.split(sign)
        yield mutant("row too short", [sign.join(cells[:-1])])
        yield mutant("row too short", [sign.join(cells[1:])])
        yield mutant("row too long", [sign.join([*cells, b"1.5"])])
        yield mutant("row cut by a line end", [line[:12], line[12:]])
        yield mutant("two rows joined", [line + b" "])
        if after and at + 1 < table.stop:
            joined = [*before, line + after[0], *after[1:]]
            yield Mutant("two rows joined", seed, b"\n".join(joined), rows=2)
            swapped = [*before, after[0], line, *after[1:]]
            yield Mutant("rows exchanged", seed, b"\n".join(swapped), rows=2)
        for count in (2, 3, 20):
            cut = [*before, *lines[at + count :]] if at + count < table.stop else before
            yield Mutant("rows deleted", seed, b"\n".join(cut), rows=count)


def cells_changed(seed: Seed) -> Iterator[Mutant]:
    """Cells that hold what is no number, or another one."""
    lines = seed.content.split(b"\n")
    sign = seed.delimiter.encode()
    for at in seed.table:
        cells = lines[at].split(sign)
        for column in range(len(cells)):
            for word in WORDS:
                row = sign.join([*cells[:column], word.encode(), *cells[column + 1 :]])
                content = b"\n".join([*lines[:at], row, *lines[at + 1 :]])
                yield Mutant("cell replaced by a word", seed, content, rows=1)


def rewritten(seed: Seed) -> Iterator[Mutant]:
    """The same text with other line ends, in other encodings."""
    content, text = seed.content, seed.content.decode()
    for end in (b"\r\n", b"\r", b"\n\n", b"\r\r\n", b" \n", b"\x0b\n", b"\0\n"):
        yield Mutant("other line ends", seed, content.replace(b"\n", end), rows=0)
    for encoding in ("utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1"):
        yield Mutant("another encoding", seed, text.encode(encoding), rows=0)
        other = text.replace("ch1", "ch\u00fc").encode(encoding)
        yield Mutant("another encoding", seed, other, rows=0)
    for at in range(0, len(content), 7):
        for what in (b"\0", b"\n", b"\r", b"\xff", b"\xef\xbb\xbf"):
            yield Mutant("a letter put in", seed, content[:at] + what + content[at:])
