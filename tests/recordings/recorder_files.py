"""Files of recorders, each written by the library of its format or from its description."""

import struct
from pathlib import Path

import numpy as np


def write_mdf(path, groups, start=None, *, version="4.10", compression=0):
    """Write groups of (name, unit, times [s], values) with asammdf."""
    from asammdf import MDF, Signal

    with MDF(version=version) as file:
        if start is not None:
            file.start_time = start
        for number, channels in enumerate(groups, 1):
            signals = [
                Signal(values, times, name=name, unit=unit)
                for name, unit, times, values in channels
            ]
            file.append(signals, comment=f"raster {number}")
        file.save(path, overwrite=True, compression=compression)


def _nested(pairs):
    """Return pairs of name and content as ebmlite takes them: lists of what is repeated."""
    if not isinstance(pairs, list):
        return pairs
    found = {}
    for name, content in pairs:
        found.setdefault(name, []).append(_nested(content))
    return {name: many if len(many) > 1 else many[0] for name, many in found.items()}


def write_ide(path, sensors, seconds_since_1970, *, ticks=1e9, block=1000):
    """Write sensors of (number, name, unit, names, rate [Hz], values) with ebmlite.

    The schema is the one that idelib ships; each block says its first and its last time.
    """
    import idelib
    from ebmlite import loadSchema

    schema = loadSchema(str(Path(idelib.__file__).parent / "schemata" / "mide_ide.xml"))
    head = [
        ("EBMLVersion", 1), ("EBMLReadVersion", 1), ("EBMLMaxIDLength", 4),
        ("EBMLMaxSizeLength", 8), ("DocType", "mide"), ("DocTypeVersion", 2),
        ("DocTypeReadVersion", 2),
    ]  # fmt: skip
    channels = [
        ("Channel", [
            ("ChannelID", number), ("ChannelName", name),
            ("TimeCodeScale", f"1/{ticks:.0f}"), ("TimeCodeModulus", 1 << 62),
            ("ChannelFormat", "<" + "f" * len(names)),
            *(("SubChannel", [
                ("SubChannelID", i), ("SubChannelName", one), ("SubChannelLabel", "quantity"),
                ("SubChannelUnits", unit), ("SubChannelSensorRef", 0),
            ]) for i, one in enumerate(names)),
        ])
        for number, name, unit, names, _, _ in sensors
    ]  # fmt: skip
    properties = [
        ("RecorderInfo", [("RecorderTypeUID", 18), ("RecorderSerial", 1234)]),
        ("SensorList", [("Sensor", [("SensorID", 0), ("SensorName", "sensor")])]),
        ("ChannelList", channels),
    ]
    content = [
        ("EBML", head), ("RecordingProperties", properties),
        ("TimeBaseUTC", seconds_since_1970),
    ]  # fmt: skip
    for number, _, _, _, rate, values in sensors:
        for first in range(0, values.shape[1], block):
            piece = values[:, first : first + block]
            last = first + piece.shape[1] - 1
            content.append(("ChannelDataBlock", [
                ("ChannelIDRef", number),
                ("StartTimeCodeAbs", round(first / rate * ticks)),
                ("EndTimeCodeAbs", round(last / rate * ticks)),
                ("ChannelDataPayload", piece.T.astype("<f4").tobytes()),
            ]))  # fmt: skip
    parts = [schema.document.encodePayload({name: _nested(one)}) for name, one in content]
    path.write_bytes(b"".join(parts))


def write_famos(path, channels, step, date):
    """Write channels of (name, unit, values) as version 2 of the format, key after key."""

    def key(name, version, *fields):
        body = ",".join(map(str, fields))
        return f"|{name},{version},{len(body)},{body};".encode("latin-1")

    data = b"".join(np.asarray(values, "<f8").tobytes() for _, _, values in channels)
    head, at = b"|CF,2,1,1;|CK,1,3,1,1;", 0
    for name, unit, values in channels:
        size = 8 * len(values)
        head += key("CG", 1, 1, 1, 1) + key("CD", 2, repr(step), 1, 1, "s", 0, 0, 0, 0.0, 1)
        head += key("NT", 1, *date) + key("CC", 1, 1, 1) + key("CP", 1, 1, 8, 8, 64, 0, 0, 1, 0)
        head += key("Cb", 1, 1, 0, 1, 1, at, size, 0, size, 1, 0.0, 0.0, "")
        head += key("CR", 1, 0, 1.0, 0.0, 1, len(unit), unit)
        head += key("CN", 1, 0, 0, 0, len(name), name, 0, "")
        at += size
    path.write_bytes(head + f"|CS,1,{2 + len(data)},1,".encode() + data + b";")


def rpc3_bytes(values, scales, step, *, per_group=64, order="<", changed=None):
    """Return whole numbers as an RPC III file, from its description; `changed` is put last."""
    n_channels, n = values.shape
    groups = -(-n // per_group)
    named = {
        "FORMAT": "BINARY" if order == "<" else "BINARY_IEEE_BIG_END",
        "NUM_HEADER_BLOCKS": "8", "NUM_PARAMS": "", "FILE_TYPE": "TIME_HISTORY",
        "DATA_TYPE": "SHORT_INTEGER", "CHANNELS": n_channels, "DELTA_T": step,
        "PTS_PER_FRAME": per_group, "PTS_PER_GROUP": per_group, "FRAMES": groups, "SAMPLES": n,
    }  # fmt: skip
    for number, scale in enumerate(scales, 1):
        named[f"DESC.CHAN_{number}"] = f"ch{number}"
        named[f"UNITS.CHAN_{number}"] = "g"
        named[f"SCALE.CHAN_{number}"] = repr(float(scale))
    named["NUM_PARAMS"] = len(named)
    named |= changed or {}
    head = b"".join(
        struct.pack("32s96s", k.encode(), str(v).encode()) for k, v in named.items()
    )
    full = np.zeros((n_channels, groups * per_group), f"{order}i2")
    full[:, :n] = values
    body = full.reshape(n_channels, groups, per_group).swapaxes(0, 1).tobytes()
    return head.ljust(8 * 512, b"\0") + body
