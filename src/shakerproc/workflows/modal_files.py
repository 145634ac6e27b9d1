r"""Files of a modal analysis in a folder, of its own or of a batch.

A complex mode stands in a data set 55 with its eigenvalue and modal A, by which the receptance
[m/N] is

.. math:: H_{rk}(\omega) = \sum \frac{\phi_r \phi_k}{a (i\omega - \lambda)}
    + \frac{\phi_r^* \phi_k^*}{a^* (i\omega - \lambda^*)}

with a where a force and a sensor share a place (driving point), else 0.
"""

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shakerproc import files
from shakerproc.data import ComplexArray
from shakerproc.geometry import Place, Wireframe, data_sets
from shakerproc.geometry.data_sets import NodalShape
from shakerproc.geometry.wireframe import numbered_nodes
from shakerproc.modal.analysis import ModalAnalysis, TestModes, file_name
from shakerproc.modal.geometry import motion_of
from shakerproc.recordings.writers.uff import (
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
from shakerproc.workflows.modal_tables import (
    mode_columns,
    reciprocity_columns,
    shape_columns,
    track_columns,
    trend_columns,
)

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
    modes, found = one.modes, np.zeros(one.modes.poles.size, complex)
    count = (modes.poles.size, len(one.sensors), len(one.inputs))
    if modes.model is None or modes.model.residues.size != np.prod(count):
        return found
    residues = modes.model.residues.reshape(count)
    strongest = np.zeros(found.size)
    for row, sensor in enumerate(one.sensors):
        for column, place in enumerate(one.input_places):
            sense = sense_of((one.positions[row], one.directions[row]), place)
            if not sense or sensor.unit not in _RATES or one.input_units[column] != "N":
                continue
            residue = residues[:, row, column] / modes.poles ** _RATES[sensor.unit]
            better = np.abs(modes.shapes[:, row]) > strongest
            squared = sense * modes.shapes[:, row] ** 2
            found[better] = squared[better] / residue[better]
            strongest[better] = np.abs(modes.shapes[better, row])
    return found


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
