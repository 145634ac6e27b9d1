"""A campaign as the laboratory would hand it over: TDMS files, test log, model."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from blind.campaign import Campaign, TestRun
from blind.excitations import SAMPLE_RATE, Drive
from blind.structures import G, Structure

SENSED = {"acceleration": ("g", G), "displacement": ("m", 1.0), "velocity": ("m/s", 1.0)}


def write(campaign: Campaign, folder: Path) -> tuple[Path, Path]:
    """Write recordings, testlog.yaml and model.yaml; return the paths of log and model."""
    folder.mkdir(parents=True, exist_ok=True)
    for test in campaign.tests:
        target = folder / "recordings" / f"Test_{test.number}"
        target.mkdir(parents=True, exist_ok=True)
        _write_tdms(campaign, test, target / "Acceleration.tdms")
    log, model = folder / "testlog.yaml", folder / "model.yaml"
    _write_yaml(log, log_document(campaign))
    _write_yaml(
        model,
        model_document(
            campaign.nominal,
            f"blind {campaign.seed}",
            campaign.details["known"],
            free=campaign.tests[0].drive.kind == "free decay",
        ),
    )
    return log, model


def log_document(campaign: Campaign) -> dict[str, Any]:
    """Return the test log as a mapping."""
    structure = campaign.structure
    forced = structure.force_on >= 0
    seen = structure.measures.removeprefix("relative ")
    role = {"acceleration": "response"}.get(seen, seen)
    channels: dict[str, Any] = (
        {"force": {"role": "force", "at": structure.name(structure.force_on)}}
        if forced
        else {
            f"control {i + 1}": {"role": "control"}
            for i in range(len(campaign.tests[0].control))
        }
    )
    for i in range(len(structure.masses)):
        channels[f"response {i + 1}"] = {
            "role": role, "name": f"ch{3 + i}", "at": structure.name(i),
        }  # fmt: skip
    return {
        "testlog": 1,
        "title": f"Blind campaign {campaign.seed}",
        "recordings": "recordings",
        "channels": channels,
        "processing": {"crop": "none"},
        "tests": [_test_document(test, forced=forced) for test in campaign.tests],
    }


def _test_document(test: TestRun, *, forced: bool) -> dict[str, Any]:
    drive = test.drive
    low, high = (drive.low_hz, drive.high_hz) if drive.up else (drive.high_hz, drive.low_hz)
    document: dict[str, Any] = {
        "id": test.number,
        "recording": f"Test_{test.number}/Acceleration.tdms",
        "joint": "radial",
        "excitation": drive.kind,
    }
    if drive.kind == "free decay":
        return document
    document["level"] = level_text(drive, forced=forced)
    if drive.kind == "random":
        document |= {"from": f"{drive.low_hz:.6g} Hz", "to": f"{drive.high_hz:.6g} Hz"}
    else:
        seconds = test.clean.shape[1] / SAMPLE_RATE - drive.lead_in - drive.tail
        octaves = np.log2(drive.high_hz / drive.low_hz)
        document |= {"from": f"{low:.6g} Hz", "to": f"{high:.6g} Hz",
                     "rate": f"{60.0 * octaves / seconds:.6g} oct/min"}  # fmt: skip
    if test.hold_out:
        document["hold_out"] = True
    return document


def level_text(drive: Drive, *, forced: bool) -> str:
    """Return the level as the log sheet writes it."""
    value, unit = (drive.level, "N") if forced else (drive.level / G, "g")
    if drive.kind == "random":
        return f"{value**2 / (drive.high_hz - drive.low_hz):.6g} {unit}^2/Hz"
    return f"{value:.6g} {unit}"


def model_document(
    structure: Structure,
    title: str,
    known: Sequence[dict[str, Any]] = (),
    *,
    free: bool = False,
) -> dict[str, Any]:
    """Return the nominal model as a mapping, with the effects that it holds already."""
    name = structure.name
    elements: list[dict[str, Any]] = list(known)
    for joint in structure.joints:
        for kind, parameter, value in (
            ("spring", "stiffness", f"{joint.stiffness:.10g} N/m"),
            ("damper", "damping", f"{joint.damping:.10g} N s/m"),
        ):
            if kind == "spring" and not joint.stiffness:
                continue  # a rack
            between = [name(joint.first), name(joint.second)]
            elements.append({"kind": kind, "between": between, parameter: value})
    excitation: dict[str, str] = {"base": "acceleration"}
    if free:
        excitation = {"free": "decay"}
    elif structure.force_on >= 0:
        excitation = {"force on": name(structure.force_on)}
    return {
        "model": 1,
        "title": title,
        "masses": {name(i): f"{m:.10g} kg" for i, m in enumerate(structure.masses)},
        "elements": elements,
        "excitation": excitation,
        "sensors": {
            f"ch{3 + i}": {"at": name(i), "measures": structure.measures}
            for i in range(len(structure.masses))
        },
    }


def _write_yaml(path: Path, document: dict[str, Any]) -> None:
    path.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")


def _write_tdms(campaign: Campaign, test: TestRun, path: Path) -> None:
    structure = campaign.structure
    inputs = ["force"] if structure.force_on >= 0 else ["control 1", "control 2"]
    unit_in = ("N", 1.0) if structure.force_on >= 0 else ("g", G)
    rows = [(name, row, *unit_in) for name, row in zip(inputs, test.control, strict=False)]
    rows += [
        (f"response {i + 1}", row, *SENSED[structure.measures.removeprefix("relative ")])
        for i, row in enumerate(test.response)
    ]
    group = "Acceleration"
    objects: list[Any] = [RootObject({"name": path.stem}), GroupObject(group)]
    for name, row, unit, scale in rows:
        properties = {
            "wf_increment": 1.0 / campaign.rate,
            "wf_samples": row.size,
            "wf_start_offset": 0.0,
            "wf_start_time": np.datetime64(f"2018-03-01T09:0{test.number}:00"),
            "unit_string": unit,
        }
        objects.append(ChannelObject(group, name, row / scale, properties))
    with TdmsWriter(path) as writer:
        writer.write_segment(objects)
