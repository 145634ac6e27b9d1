"""Ways in which a file goes wrong."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from tests.fuzz.seeds import Seed

EXTREMES = [
    struct.pack("<I", value) for value in (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
] + [struct.pack("<Q", value) for value in (0, 2**31, 2**63 - 1, 2**64 - 1)]
PAYLOAD_FLIPS = 150
OTHER_FLIPS = 1500


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
    """

    kind: str
    seed: Seed
    content: bytes
    index: bytes | None = None
    while_open: bytes | None = None


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
