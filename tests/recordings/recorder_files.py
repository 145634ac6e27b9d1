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


def write_ide(path, sensors, seconds_since_1970, *, ticks=1e9, block=1000, calibrations=()):
    """Write sensors of (number, name, unit, names, rate [Hz], values) with ebmlite.

    The schema is the one that idelib ships; each block says its first and its last time.
    `calibrations` are elements of polynomials; each axis is calibrated by the one of the
    number of its sensor, if there is one.
    """
    import idelib
    from ebmlite import loadSchema

    schema = loadSchema(str(Path(idelib.__file__).parent / "schemata" / "mide_ide.xml"))
    head = [
        ("EBMLVersion", 1), ("EBMLReadVersion", 1), ("EBMLMaxIDLength", 4),
        ("EBMLMaxSizeLength", 8), ("DocType", "mide"), ("DocTypeVersion", 2),
        ("DocTypeReadVersion", 2),
    ]  # fmt: skip
    calibrated = {dict(content)["CalID"] for _, content in calibrations}
    channels = [
        ("Channel", [
            ("ChannelID", number), ("ChannelName", name),
            ("TimeCodeScale", f"1/{ticks:.0f}"), ("TimeCodeModulus", 1 << 62),
            ("ChannelFormat", "<" + "f" * len(names)),
            *(("SubChannel", [
                ("SubChannelID", i), ("SubChannelName", one), ("SubChannelLabel", "quantity"),
                ("SubChannelUnits", unit), ("SubChannelSensorRef", 0),
                *[("SubChannelCalibrationIDRef", number)] * (number in calibrated),
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
        *[("CalibrationList", list(calibrations))] * bool(calibrations),
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
    named["NUM_PARAMS"] = len(named | (changed or {}))
    named |= changed or {}
    head = b"".join(
        struct.pack("32s96s", k.encode(), str(v).encode()) for k, v in named.items()
    )
    full = np.zeros((n_channels, groups * per_group), f"{order}i2")
    full[:, :n] = values
    body = full.reshape(n_channels, groups, per_group).swapaxes(0, 1).tobytes()
    return head.ljust(8 * 512, b"\0") + body


_ATFX_MODEL = {
    "Messung": ("AoMeasurement", {"Id": "id", "Name": "name", "Beginn": "measurement_begin",
        "Teile": "submatrices", "Kanaele": "measurement_quantities"}),
    "Kanal": ("AoMeasurementQuantity", {"Id": "id", "Name": "name", "Typ": "datatype",
        "Messung": "measurement", "Einheit": "unit", "Groesse": "quantity"}),
    "Groesse": ("AoQuantity", {"Id": "id", "Name": "name"}),
    "Einheit": ("AoUnit", {"Id": "id", "Name": "name", "Faktor": "factor", "Null": "offset"}),
    "Teil": ("AoSubmatrix", {"Id": "id", "Name": "name", "Zeilen": "number_of_rows",
        "Messung": "measurement", "Spalten": "local_columns"}),
    "Spalte": ("AoLocalColumn", {"Id": "id", "Name": "name", "Frei": "independent",
        "Art": "sequence_representation", "Zahlen": "generation_parameters",
        "Werte": "values", "Marken": "flags", "Marke": "global_flag", "Teil": "submatrix",
        "Kanal": "measurement_quantity", "Fremd": "external_component"}),
    "Fremd": ("AoExternalComponent", {"Id": "id", "Name": "name", "Datei": "filename_url",
        "Typ": "value_type", "Laenge": "component_length", "Anfang": "start_offset",
        "Block": "block_size", "JeBlock": "valuesperblock", "Versatz": "value_offset"}),
}  # fmt: skip
"""Names of a vendor's own for elements of the base model, as every vendor has them."""


def atfx(submatrices, *, begin="", files=None, version="5.3.0"):
    """Return the XML of submatrices of (name, rows, columns) after the published schema.

    A column is (name, unit, quantity, content): content is its XML after `Frei`; of the
    independent one, a pair of start and step, or a list of its XML. Relations stand on one
    side only.
    """

    def tags(**fields):
        return "".join(f"<{k}>{v}</{k}>" for k, v in fields.items())

    relations = {
        "submatrices", "measurement_quantities", "measurement", "unit", "quantity",
        "local_columns", "submatrix", "measurement_quantity", "external_component",
    }  # fmt: skip
    model = ""
    for kind, (base, names) in _ATFX_MODEL.items():
        inner = "".join(
            f"<relation_attribute>{tags(name=n, ref_to='any', base_relation=b)}"
            "</relation_attribute>"
            if b in relations
            else f"<application_attribute>{tags(name=n, base_attribute=b)}"
            "</application_attribute>"
            for n, b in names.items()
        )
        element = tags(name=kind, basetype=base) + inner
        model += f"<application_element>{element}</application_element>"
    listed = "".join(
        f"<component>{tags(identifier=k, filename=v)}</component>"
        for k, v in (files or {}).items()
    )
    data, number = f"<Messung>{tags(Id=1, Name='run', Beginn=begin)}</Messung>", 1
    for name, rows, columns in submatrices:
        number += 1
        part, spalten = number, []
        for called, unit, quantity, content in columns:
            column, kanal, einheit, groesse = range(number + 1, number + 5)
            number += 4
            free = not isinstance(content, str)
            inner = content[0] if isinstance(content, list) else content
            if isinstance(content, tuple):
                step = " ".join(map(repr, content))
                inner = tags(Art="implicit_linear", Zahlen=step)
            data += f"<Einheit>{tags(Id=einheit, Name=unit, Faktor=1, Null=0)}</Einheit>"
            data += f"<Groesse>{tags(Id=groesse, Name=quantity)}</Groesse>"
            data += f"<Kanal>{tags(Id=kanal, Name=called, Messung=1, Einheit=einheit)}"
            data += f"{tags(Groesse=groesse)}</Kanal>"
            data += f"<Spalte>{tags(Id=column, Name=called, Frei=int(free), Kanal=kanal)}"
            data += f"{inner}</Spalte>"
            spalten.append(str(column))
        about = tags(Id=part, Name=name, Zeilen=rows, Messung=1, Spalten=" ".join(spalten))
        data += f"<Teil>{about}</Teil>"
    return (
        f'<?xml version="1.0" encoding="utf-8"?>\n<atfx_file version="atfx_file: V1.3.0" '
        f'xmlns="http://www.asam.net/ODS/{version}/Schema">'
        f"<documentation><exporter>test</exporter></documentation>"
        f"<base_model_version>asam31</base_model_version><files>{listed}</files>"
        f"<application_model>{model}</application_model>"
        f"<instance_data>{data}</instance_data></atfx_file>\n"
    )


def atfx_explicit(values, tag="A_FLOAT64", more=""):
    """Return the content of a column whose values are written out."""
    written = " ".join(map(repr, np.asarray(values).tolist()))
    inner = f"<Art>explicit</Art><Marke>15</Marke><Werte><{tag}>{written}</{tag}></Werte>"
    return inner + more


def atfx_component(name, kind, length, first, block, offset):
    """Return numbers of a binary file, as IPETRONIK and HEAD acoustics write them."""
    return (
        f"<component><identifier>{name}</identifier><datatype>{kind}</datatype>"
        f"<length>{length}</length><inioffset>{first}</inioffset><valperblock>1</valperblock>"
        f"<valoffsets>{offset}</valoffsets><blocksize>{block}</blocksize></component>"
    )
