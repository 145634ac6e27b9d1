"""Sensors under periodic motions: harmonics, peaks, and a table of a whole response."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models import BASE, Model, Sensor
from shakerproc.models.coordinates import coordinates_of, resolved
from shakerproc.models.laws import Law
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.branch import Branch
from shakerproc.simulation.harmonic_balance.response import Response

Columns: TypeAlias = Mapping[str, NDArray[np.generic]]

_RATES: Final = {"displacement": 0, "velocity": 1, "acceleration": 2}


def sensors_of_model(model: Model) -> Mapping[str, Sensor]:
    """Return the sensors of a model; without any, two for each mass and point."""
    if model.sensors:
        return model.sensors
    sensors: dict[str, Sensor] = {}
    for name in model.moving:
        sensors[f"{name} acceleration"] = Sensor(name, "acceleration")
        sensors[f"{name} displacement"] = Sensor(name, "relative displacement")
    return sensors


def sensor_harmonics(
    model: Model, level: float, branch: Branch, sensor: Sensor
) -> ComplexArray:
    """Return the harmonics that a sensor measures at every point of a branch.

    Parameters
    ----------
    model : Model
        What is shaken.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    branch : Branch
        Its motions.
    sensor : Sensor
        What is measured; its faults are left out.

    Returns
    -------
    (n_points, n_harmonics) array
        Complex amplitudes against a cosine excitation [m], [m/s] or [m/s²].
    """
    balance = branch.balance
    omega = 2.0 * np.pi * branch.frequency[:, None]
    rate = 1j * omega / balance.order * balance.harmonics
    motion = np.zeros(rate.shape, np.complex128)
    if sensor.at != BASE:
        direction = coordinates_of(model).at(sensor.at)
        motion = np.tensordot(branch.coefficients, direction, axes=(1, 0))
    relative = sensor.measures.startswith("relative")
    if model.excitation.on is None and not relative:
        motion[:, balance.harmonics == balance.order] -= level / omega**2
    return np.asarray(motion * rate ** _RATES[sensor.measures.removeprefix("relative ")])


def peaks(branch: Branch, harmonics: ComplexArray) -> FloatArray:
    """Return the largest magnitude over a period of (n_points, n_harmonics) motions.

    `harmonics` may be in any unit.
    """
    n_samples = max(256, 16 * int(branch.balance.harmonics[-1]))
    return np.asarray(
        np.max(np.abs(fourier.values(harmonics, branch.balance.harmonics, n_samples)), axis=-1)
    )


def gap_severity(model: Model, level: float) -> Mapping[str, float]:
    """Return the load over the force that closes each gap fully, F / (k a) [-].

    Only this number decides the shape of the response of a mass with free play. The force of a
    base acceleration is that on all masses.

    Parameters
    ----------
    model : Model
        What is shaken.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    """
    force = level * (model.moved_mass if model.excitation.on is None else 1.0)
    values: dict[str, float] = {}
    for element in resolved(model):
        closing = [
            row.values[0] * abs(row.values[1])
            for row in element.effect.rows()
            if row.law in {Law.STOP, Law.JUMP}
        ]
        if closing and max(closing) > 0.0:
            name = f"{element.effect.kind} between {' and '.join(element.between)}"
            values[name] = force / max(closing)
    return values


@final
@dataclass(frozen=True, slots=True)
class Notable:
    """A point of a response that people look for.

    Attributes
    ----------
    branch : int
        Number of the branch, from 1.
    order : int
        Periods of the excitation after which the motion repeats.
    what : str
        ``begins``, ``peak``, a mark of the branch, or ``ends``.
    frequency_hz : float
        Frequency of the excitation [Hz].
    peak : float
        Largest value of the sensor over a period [unit of the sensor].
    stable : bool
        Whether the motion attracts its neighbours.
    largest_multiplier : float
        Growth of a disturbance in one period [-].
    """

    branch: int
    order: int
    what: str
    frequency_hz: float
    peak: float
    stable: bool
    largest_multiplier: float


def notable_points(
    response: Response, name: str, others: tuple[Branch, ...] = ()
) -> tuple[Notable, ...]:
    """Return ends, peaks, folds and changes of stability of every branch, for one sensor.

    Parameters
    ----------
    response : Response
        The curve.
    name : str
        Name of the sensor.
    others : tuple of Branch
        Further branches.
    """
    sensor = sensors_of_model(response.model)[name]
    notables: list[Notable] = []
    for number, branch in enumerate((*response.branches, *others), start=1):
        height = peaks(branch, sensor_harmonics(response.model, response.level, branch, sensor))
        rises = np.diff(height) > 0.0
        events = {int(i) + 1: "peak" for i in np.flatnonzero(rises[:-1] & ~rises[1:])}
        events |= {0: "begins", height.size - 1: "ends"}
        events |= {mark.index: mark.kind for mark in branch.marks}
        notables += [
            Notable(
                branch=number,
                order=branch.balance.order,
                what=events[i],
                frequency_hz=float(branch.frequency[i]),
                peak=float(height[i]),
                stable=bool(branch.stable[i]),
                largest_multiplier=float(np.abs(branch.multipliers[i, 0])),
            )
            for i in sorted(events)
        ]
    return tuple(notables)


def response_columns(response: Response, others: tuple[Branch, ...] = ()) -> Columns:
    """Return a table of every point of a response, one column a quantity.

    Parameters
    ----------
    response : Response
        The curve.
    others : tuple of Branch
        Further branches: without symmetry, of double period, subharmonic.

    Returns
    -------
    mapping of str to (n_points,) array
        Branch number and order, frequency, stability, then for each sensor the peak, the
        harmonic of the excitation and its phase.
    """
    tables = [
        _columns(response, number, branch)
        for number, branch in enumerate((*response.branches, *others), start=1)
    ]
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def _in_header(unit: str) -> str:
    return unit.replace("/s^2", "_per_s2").replace("/s", "_per_s").replace(" ", "")


def _columns(response: Response, number: int, branch: Branch) -> Columns:
    size = branch.frequency.size
    marks = np.full(size, "", dtype=object)
    for mark in branch.marks:
        marks[mark.index] = mark.kind
    table: dict[str, NDArray[np.generic]] = {
        "branch": np.full(size, number),
        "order": np.full(size, branch.balance.order),
        "frequency_hz": branch.frequency,
        "stable": branch.stable,
        "largest_multiplier": np.abs(branch.multipliers[:, 0]),
        "mark": marks,
    }
    for name, sensor in sensors_of_model(response.model).items():
        harmonics = sensor_harmonics(response.model, response.level, branch, sensor)
        column, unit = name.replace(" ", "_"), _in_header(response.model.sensor_unit(sensor))
        main = harmonics[:, branch.balance.harmonics == branch.balance.order][:, 0]
        table[f"{column}_peak_{unit}"] = peaks(branch, harmonics)
        table[f"{column}_harmonic_{unit}"] = np.abs(main)
        table[f"{column}_phase_deg"] = np.degrees(np.angle(main))
    return table
