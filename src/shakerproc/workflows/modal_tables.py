r"""A modal analysis as tables, as JSON, and as files in a folder.

A complex mode stands in a data set 55 with its eigenvalue and modal A, by which the receptance
[m/N] is

.. math:: H_{rk}(\omega) = \sum \frac{\phi_r \phi_k}{a (i\omega - \lambda)}
    + \frac{\phi_r^* \phi_k^*}{a^* (i\omega - \lambda^*)}

with a where a force and a sensor share a place (driving point), else 0.
"""

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from shakerproc import __version__, files
from shakerproc.campaign.trends import mode_shifts, trends_of_modes
from shakerproc.data import ComplexArray
from shakerproc.geometry import Place, Wireframe, data_sets, numbered_nodes
from shakerproc.geometry.data_sets import NodalShape
from shakerproc.modal.analysis import ModalAnalysis, TestModes, file_name, mac_over
from shakerproc.modal.geometry import motion_of
from shakerproc.modal.modal_model import ModeSet
from shakerproc.modal.shapes import mac
from shakerproc.recordings.writers import (
    FREQUENCY,
    QUANTITIES,
    RESPONSE,
    End,
    RecordAxis,
    RecordHead,
    direction_of,
    write_function,
)
from shakerproc.report.modal.sections import modal_report
from shakerproc.report.page.page import write_report
from shakerproc.runs.roles import sense_of

SCHEMA: Final = "shakerproc-modal/1"


def track_columns(analysis: ModalAnalysis) -> dict[str, list[object]]:
    """Return each mode through the tests, as columns."""
    tests = analysis.tests
    columns: dict[str, list[object]] = {
        "mode": [i + 1 for i in range(len(analysis.tracks))],
        "tests": [len(track.sightings) for track in analysis.tracks],
    }
    table: dict[str, list[object]] = {
        name: []
        for name in (
            "frequency_hz", "frequency_scatter_percent", "damping_percent",
            "damping_scatter_percent", "frequency_first_to_last_percent", "least_mac",
        )
    }  # fmt: skip
    for track in analysis.tracks:
        f = np.array([tests[s.test].modes.frequency[s.mode] for s in track.sightings])
        z = np.array([tests[s.test].modes.damping[s.mode] for s in track.sightings])
        several = f.size > 1
        table["frequency_hz"].append(float(f.mean()))
        table["damping_percent"].append(float(100.0 * z.mean()))
        spread = [
            float(100.0 * v.std(ddof=1) / v.mean()) if several else np.nan for v in (f, z)
        ]
        table["frequency_scatter_percent"].append(spread[0])
        table["damping_scatter_percent"].append(spread[1])
        shift = float(100.0 * (f[-1] / f[0] - 1.0)) if several else np.nan
        table["frequency_first_to_last_percent"].append(shift)
        mac_values = [s.mac for s in track.sightings if s.mac is not None]
        table["least_mac"].append(min(mac_values) if several and mac_values else np.nan)
    return {**columns, **table}


def track_rows(analysis: ModalAnalysis) -> list[tuple[object, ...]]:
    """Return each mode through the tests, as rows."""
    return list(zip(*track_columns(analysis).values(), strict=True))


def mode_columns(analysis: ModalAnalysis) -> dict[str, list[object]]:
    """Return one row for each mode of each test."""
    names = (
        "test", "mode", "track", "frequency_hz", "frequency_low_hz", "frequency_high_hz",
        "damping", "damping_low", "damping_high", "collinearity", "mac_with_first", "method",
        "joint", "specimen", "clearance_m", "excitation", "level",
        "frequency_scatter_percent", "damping_scatter_percent",
    )  # fmt: skip
    columns: dict[str, list[object]] = {name: [] for name in names}
    tracked = {
        (s.test, s.mode): (number, s.mac)
        for number, track in enumerate(analysis.tracks, 1)
        for s in track.sightings
    }
    for place, one in enumerate(analysis.tests):
        modes = one.modes
        for i in range(modes.poles.size):
            number, mac_value = tracked[place, i]
            row = (
                one.name, i + 1, number, float(modes.frequency[i]),
                *map(float, modes.frequency_bounds[:, i]), float(modes.damping[i]),
                *map(float, modes.damping_bounds[:, i]), float(modes.collinearity[i]),
                mac_value, modes.method, one.test.joint, one.test.specimen, one.test.clearance,
                one.test.excitation or "", one.test.level_text, *_scatter(modes, i),
            )  # fmt: skip
            for name, value in zip(names, row, strict=True):
                columns[name].append(value)
    return columns


def _scatter(modes: ModeSet, mode: int) -> list[float]:
    """Return the scatter of frequency and damping over tests of one fit [%]."""
    if modes.scatter is None:
        return [np.nan, np.nan]
    return [float(100.0 * value) for value in modes.scatter[:, mode]]


def shape_columns(analysis: ModalAnalysis) -> dict[str, list[object]]:
    """Return one row for each mode and sensor."""
    names = ("test", "mode", "sensor", "x_m", "y_m", "z_m", "direction", "real", "imaginary")
    columns: dict[str, list[object]] = {name: [] for name in names}
    for one in analysis.tests:
        for i, shape in enumerate(one.modes.shapes):
            for k, sensor in enumerate(one.sensors):
                place = one.positions[k] or (None, None, None)
                along = one.directions[k]
                text = "" if along is None else " ".join(f"{v:g}" for v in along)
                row = (
                    one.name, i + 1, sensor.name, *place, text,
                    float(shape[k].real), float(shape[k].imag),
                )  # fmt: skip
                for name, value in zip(names, row, strict=True):
                    columns[name].append(value)
    return columns


def trend_columns(analysis: ModalAnalysis) -> dict[str, list[object]]:
    """Return one row for each point of every trend of every mode."""
    rows = [
        (number, trend.name, trend.x_label, label, point.test, point.x, point.frequency_hz,
         point.bin_width_hz)
        for number, trends in trends_of_modes(analysis).items()
        for trend in trends
        for label, points in trend.series.items()
        for point in points
    ]  # fmt: skip
    names = (
        "mode", "trend", "against", "series", "test", "x", "frequency_hz", "interval_width_hz",
    )  # fmt: skip
    return {name: [row[i] for row in rows] for i, name in enumerate(names)}


def reciprocity_columns(analysis: ModalAnalysis) -> dict[str, list[object]]:
    """Return one row for each pair of functions between the same two places."""
    pairs = analysis.reciprocals
    return {
        "function": [pair.names[0] for pair in pairs],
        "reciprocal": [pair.names[1] for pair in pairs],
        "correlation": [pair.correlation for pair in pairs],
        "size_ratio": [pair.ratio for pair in pairs],
        "agrees": [not pair.problem for pair in pairs],
    }


def document_of(analysis: ModalAnalysis, path: Path) -> dict[str, Any]:
    """Return the JSON document of a modal analysis of a log or a file of functions."""
    columns, pairs = track_columns(analysis), reciprocity_columns(analysis)
    return {
        "schema": SCHEMA,
        "shakerproc": __version__,
        "title": analysis.title,
        "log": path.name,
        "tests": [_test_document(one) for one in analysis.tests],
        "tracks": [
            {
                **{name: values[i] for name, values in columns.items()},
                "sightings": [
                    {
                        "test": analysis.tests[s.test].name,
                        "mode": s.mode + 1,
                        "mac_with_first": s.mac,
                    }
                    for s in track.sightings
                ],
            }
            for i, track in enumerate(analysis.tracks)
        ],
        "mac_between_tests": _between(analysis),
        "reciprocity": [
            dict(zip(pairs, row, strict=True)) for row in zip(*pairs.values(), strict=True)
        ],
        "told": list(mode_shifts(analysis)),
        "failed": [{"test": name, "reason": reason} for name, reason in analysis.failed],
        "notes": list(analysis.notes),
    }


def _between(analysis: ModalAnalysis) -> list[dict[str, Any]]:
    """Return the MAC of all modes of the first test with those of each other test."""
    rows = []
    for one in analysis.tests[1:]:
        first = analysis.tests[0]
        names = (first.sensor_names, one.sensor_names)
        values = mac_over(first.modes.shapes, one.modes.shapes, names)
        if values is not None and values.size:
            rows.append({"tests": [first.name, one.name], "mac": values.tolist()})
    return rows


def _test_document(one: TestModes) -> dict[str, Any]:
    modes = one.modes
    return {
        "test": one.name,
        "recordings": [
            {"test": test, "file": name, "sha256": sha256}
            for test, name, sha256 in one.recordings
        ],
        "recording_sha256": one.recordings[0][2] if one.recordings else None,  # former key
        "method": modes.method,
        "intervals_from": modes.interval_from,
        "band_hz": list(one.band),
        "inputs": list(one.inputs),
        "sensors": one.sensor_names,
        "positions_m": [None if p is None else list(p) for p in one.positions],
        "directions": [None if d is None else list(d) for d in one.directions],
        "unexplained": one.unexplained.tolist(),
        "modes": [
            {
                "frequency_hz": {
                    "value": float(modes.frequency[i]),
                    "low": float(modes.frequency_bounds[0, i]),
                    "high": float(modes.frequency_bounds[1, i]),
                },
                "damping": {
                    "value": float(modes.damping[i]),
                    "low": float(modes.damping_bounds[0, i]),
                    "high": float(modes.damping_bounds[1, i]),
                },
                "collinearity": float(modes.collinearity[i]),
                **_scatter_document(modes, i),
                **_residue_document(modes, i),
                "shape": {
                    "real": modes.shapes[i].real.tolist(),
                    "imaginary": modes.shapes[i].imag.tolist(),
                },
                "participation": {
                    "real": modes.participation[i].real.tolist(),
                    "imaginary": modes.participation[i].imag.tolist(),
                },
            }
            for i in range(modes.poles.size)
        ],
        "mac": mac(modes.shapes, modes.shapes).tolist() if modes.poles.size else [],
        "notes": list(one.notes),
    }


def _residue_document(modes: ModeSet, mode: int) -> dict[str, Any]:
    """Return the residues, of each response and input; none where no input was measured."""
    if modes.model is None:
        return {}
    residues = modes.model.residues[mode]
    return {"residues": {"real": residues.real.tolist(), "imaginary": residues.imag.tolist()}}


def _scatter_document(modes: ModeSet, mode: int) -> dict[str, float]:
    if modes.scatter is None:
        return {}
    frequency, damping = _scatter(modes, mode)
    return {"frequency_scatter_percent": frequency, "damping_scatter_percent": damping}


_RATES = {"m": 0, "m/s": 1, "m/s^2": 2}
"""Derivatives of the displacement that a unit stands for."""


def write_universal(path: Path, one: TestModes, title: str) -> None:
    """Write the modes of a test as text: data sets 151, 164, 2411, 82, 2412, 55 and 58."""
    forces = [place for place, _ in one.input_places]
    numbers, wireframe = numbered_nodes([*one.positions, *forces], one.wireframe)
    drawn = wireframe if any(one.positions) else Wireframe({})
    with files.atomic_path(path) as temporary, temporary.open("wb") as file:
        text = data_sets.header(title, f"modes of test {one.name}", "shakerproc")
        text += data_sets.geometry(drawn)
        text += "".join(data_sets.shape(mode) for mode in shapes_of(one, numbers))
        file.write(text.encode("ascii", errors="replace"))
        for head, row, column in _functions(one, numbers):
            values = one.functions.measured[row, column] if one.functions else np.empty(0)
            write_function(file, head, values, binary=False)


def shapes_of(one: TestModes, numbers: list[int]) -> Iterator[NodalShape]:
    """Yield the modes of a test at the nodes of its sensors, whose `numbers` come first."""
    seats = numbers[: len(one.sensors)]
    nodes = sorted(set(seats))
    along = np.array([(0.0, 0.0, 1.0) if d is None else d for d in one.directions])
    motion = motion_of([nodes.index(number) for number in seats], along, len(nodes))
    scale = modal_a(one)
    known = "receptance" if np.any(scale) else "not scaled: no driving point"
    unit = one.sensors[0].unit
    for i, values in enumerate(one.modes.shapes):
        yield NodalShape(
            texts=(
                f"test {one.name}, mode {i + 1}",
                f"{one.modes.frequency[i]:.7g} Hz, damping ratio {one.modes.damping[i]:.4g}",
                f"modal A: {known}",
                one.modes.method,
            ),
            number=i + 1,
            pole=complex(one.modes.poles[i]),
            modal_a=complex(scale[i]),
            nodes=nodes,
            values=np.einsum("s,snk->nk", values, motion),
            quantity=QUANTITIES.get(unit, 0),
        )


def modal_a(one: TestModes) -> ComplexArray:
    """Return modal A of each mode, by the strongest driving point; 0 where there is none.

    Returns
    -------
    (n_modes,) complex array
        Shapes are those of the analysis, of which the largest component is 1 [N s/m].
    """
    modes, values = one.modes, np.zeros(one.modes.poles.size, complex)
    count = (modes.poles.size, len(one.sensors), len(one.inputs))
    if modes.model is None or modes.model.residues.size != np.prod(count):
        return values
    residues = modes.model.residues.reshape(count)
    strongest = np.zeros(values.size)
    for row, sensor in enumerate(one.sensors):
        for column, place in enumerate(one.input_places):
            sense = sense_of((one.positions[row], one.directions[row]), place)
            if not sense or sensor.unit not in _RATES or one.input_units[column] != "N":
                continue
            residue = residues[:, row, column] / modes.poles ** _RATES[sensor.unit]
            better = np.abs(modes.shapes[:, row]) > strongest
            squared = sense * modes.shapes[:, row] ** 2
            values[better] = squared[better] / residue[better]
            strongest[better] = np.abs(modes.shapes[better, row])
    return values


def _functions(one: TestModes, numbers: list[int]) -> Iterator[tuple[RecordHead, int, int]]:
    """Yield head, row and column of each measured response function."""
    if one.functions is None:
        return
    lines, count = one.functions.frequency, len(one.sensors)
    for row, sensor in enumerate(one.sensors):
        for column, name in enumerate(one.inputs):
            unit = one.input_units[column]
            head = RecordHead(
                RESPONSE,
                (f"{sensor.name} to {name}", f"test {one.name}", "", "", ""),
                End(sensor.name, numbers[row], direction_of(one.directions[row])),
                _reference(name, one.input_places[column], numbers[count + column]),
                float(lines[0]),
                float(lines[1] - lines[0]),
                FREQUENCY,
                RecordAxis(QUANTITIES.get(sensor.unit, 0), "NONE", sensor.unit),
                RecordAxis(QUANTITIES.get(unit, 0), "NONE", unit),
            )
            yield head, row, column


def _reference(name: str, place: tuple[Place | None, Place | None], number: int) -> End:
    """Return the end of an input; that of no one place has no node."""
    where, along = place
    return End(name) if where is None else End(name, number, direction_of(along))


def write_modes(
    folder: Path,
    analysis: ModalAnalysis,
    document: dict[str, Any],
    logs: Sequence[Path],
    *,
    command: str,
    figures: bool,
) -> None:
    """Write tables, JSON, figures and the page of a modal analysis."""
    files.write_csv(folder / "modes.csv", mode_columns(analysis))
    files.write_csv(folder / "shapes.csv", shape_columns(analysis))
    files.write_csv(folder / "tracks.csv", track_columns(analysis))
    points = trend_columns(analysis)
    if points["mode"]:
        files.write_csv(folder / "mode_trends.csv", points)
    if analysis.reciprocals:
        files.write_csv(folder / "reciprocity.csv", reciprocity_columns(analysis))
    for one in analysis.tests:
        if one.modes.poles.size:
            write_universal(folder / f"{file_name(one.name)}.uff", one, analysis.title)
    files.write_json(folder / "report.json", document)
    if figures:
        from shakerproc.report.modal.figures import draw_modal

        draw_modal(analysis, folder)
    inputs = [("log", log.name, hashlib.sha256(log.read_bytes()).hexdigest()) for log in logs]
    inputs += [
        (f"test {test}", name, sha256)
        for one in analysis.tests
        for test, name, sha256 in one.recordings
    ]
    page = modal_report(analysis, command, tuple(inputs))
    write_report(folder / "report.html", page)
