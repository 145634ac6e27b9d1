"""TDMS files built byte by byte from NI's description of the format, for tests only."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

METADATA, NEW_LIST, RAW, INTERLEAVED, BIG, DAQMX = 2, 4, 8, 32, 64, 128
NO_DATA, AS_BEFORE = 0xFFFFFFFF, 0
CODES = {
    "i1": 1, "i2": 2, "i4": 3, "i8": 4, "u1": 5, "u2": 6, "u4": 7, "u8": 8, "f4": 9, "f8": 10,
}  # fmt: skip
SCALER_CODES = {"u1": 0, "i1": 1, "u2": 2, "i2": 3, "u4": 4, "i4": 5, "f4": 8, "f8": 9}


def text(content: str | bytes, e: str = "<") -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return struct.pack(e + "I", len(raw)) + raw


def prop(name: str, value: Any, e: str = "<") -> bytes:
    head = text(name, e)
    if isinstance(value, str | bytes):
        return head + struct.pack(e + "I", 0x20) + text(value, e)
    if isinstance(value, bool):
        return head + struct.pack(e + "IB", 0x21, value)
    if isinstance(value, int):
        return head + struct.pack(e + "II", 7, value)
    return head + struct.pack(e + "Id", 10, value)


def props(values: Mapping[str, Any], e: str = "<") -> bytes:
    return struct.pack(e + "I", len(values)) + b"".join(
        prop(n, v, e) for n, v in values.items()
    )


def index(dtype: str, count: int, e: str = "<") -> bytes:
    return struct.pack(e + "IIIQ", 20, CODES[dtype], 1, count)


def daqmx_index(
    scalers: Sequence[tuple[str, int, int, int]],
    count: int,
    widths: Sequence[int],
    e: str = "<",
) -> bytes:
    """Scalers are (dtype, buffer, byte in the row, scale number)."""
    raw = struct.pack(e + "IIIQI", 0x1269, 0xFFFFFFFF, 1, count, len(scalers))
    for dtype, buffer, byte, scale in scalers:
        raw += struct.pack(e + "IIIII", SCALER_CODES[dtype], buffer, byte, 0, scale)
    return raw + struct.pack(e + f"I{len(widths)}I", len(widths), *widths)


def listed(path: str, data: bytes | int, values: Mapping[str, Any] | None = None, e: str = "<"):
    header = struct.pack(e + "I", data) if isinstance(data, int) else data
    return text(path, e) + header + props(values or {}, e)


def metadata(objects: Sequence[bytes], e: str = "<", padding: int = 0) -> bytes:
    return struct.pack(e + "I", len(objects)) + b"".join(objects) + bytes(padding)


def segment(
    meta: bytes, raw: bytes, flags: int, *, version: int = 4713, to_next: int | None = None
) -> bytes:
    e = ">" if flags & BIG else "<"
    length = len(meta) + len(raw) if to_next is None else to_next
    head = (
        b"TDSm" + struct.pack("<I", flags) + struct.pack(e + "IQQ", version, length, len(meta))
    )
    return head + meta + raw


def chunk(columns: Sequence[np.ndarray], *, interleaved: bool, e: str) -> bytes:
    """One chunk of raw data."""
    typed = [c.astype(c.dtype.newbyteorder(e)) for c in columns]
    if not interleaved:
        return b"".join(c.tobytes() for c in typed)
    rows = np.empty(len(typed[0]), dtype=[(f"f{i}", c.dtype) for i, c in enumerate(typed)])
    for i, c in enumerate(typed):
        rows[f"f{i}"] = c
    return rows.tobytes()


@dataclass
class Builder:
    """Grows a file of one group and remembers what every channel holds."""

    dtypes: Sequence[str]
    group: str = "All Data"
    rate: float = 1000.0
    unit: str = "g"
    extra: Mapping[str, Any] = field(default_factory=dict)
    content: bytes = b""
    starts: list[int] = field(default_factory=list)
    values: list[list[np.ndarray]] = field(init=False)

    def __post_init__(self) -> None:
        self.values = [[] for _ in self.dtypes]

    def path(self, number: int) -> str:
        return f"/'{self.group}'/'ch{number + 1}'"

    def add(
        self,
        rng: np.random.Generator,
        count: int,
        n_chunks: int = 1,
        *,
        interleaved: bool = False,
        big: bool = False,
        meta: str = "full",
        padding: int = 0,
    ) -> "Builder":
        e = ">" if big else "<"
        flags = RAW | (INTERLEAVED if interleaved else 0) | (BIG if big else 0)
        block = b""
        if meta != "none":
            first = not self.starts
            flags |= METADATA | (NEW_LIST if meta == "full" or first else 0)
            own = {"wf_increment": 1.0 / self.rate, "unit_string": self.unit, **self.extra}
            objects = [
                listed(
                    self.path(i),
                    AS_BEFORE if meta == "same" else index(dtype, count, e),
                    own if first else {},
                    e,
                )
                for i, dtype in enumerate(self.dtypes)
            ]
            block = metadata(objects, e, padding)
        raw = b""
        for _ in range(n_chunks):
            columns = [random_numbers(rng, dtype, count) for dtype in self.dtypes]
            for held, column in zip(self.values, columns, strict=True):
                held.append(column)
            raw += chunk(columns, interleaved=interleaved, e=e)
        self.starts.append(len(self.content))
        self.content += segment(block, raw, flags)
        return self

    def rows(self) -> np.ndarray:
        """Every value, (n_channels, n) float64."""
        return np.array([np.concatenate(v).astype(np.float64) for v in self.values])


def random_numbers(rng: np.random.Generator, dtype: str, count: int) -> np.ndarray:
    if dtype[0] == "f":
        return rng.standard_normal(count).astype(dtype)
    info = np.iinfo(dtype)
    low, high = max(info.min, -(2**40)), min(info.max, 2**40)
    return rng.integers(low, high, count, endpoint=True).astype(dtype)


def daqmx_file(
    rng: np.random.Generator, n_channels: int = 3, count: int = 50, n_chunks: int = 2
) -> tuple[bytes, np.ndarray]:
    """A file of 16-bit DAQmx channels with linear scales, and their scaled values."""
    width = 2 * n_channels
    slopes = 0.001 * (1.0 + np.arange(n_channels))
    objects = []
    for i in range(n_channels):
        values = {
            "NI_Number_Of_Scales": 2,
            "NI_Scaling_Status": "unscaled",
            "NI_Scale[1]_Scale_Type": "Linear",
            "NI_Scale[1]_Linear_Slope": float(slopes[i]),
            "NI_Scale[1]_Linear_Y_Intercept": 0.25,
            "NI_Scale[1]_Linear_Input_Source": 0,
            "wf_increment": 0.001,
            "unit_string": "V",
        }
        scalers = [("i2", 0, 2 * i, 0)]
        objects.append(listed(f"/'g'/'ai{i}'", daqmx_index(scalers, count, [width]), values))
    counts = rng.integers(-32768, 32767, (n_chunks * count, n_channels)).astype("<i2")
    flags = METADATA | NEW_LIST | RAW | DAQMX
    content = segment(metadata(objects), counts.tobytes(), flags)
    return content, counts.T * slopes[:, None] + 0.25
