"""A picture of each effect: its loop, its equivalent stiffness and damping by level."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import EFFECTS, FAULTS
from shakerproc.models.effects import AttachedMode, StiffnessDrift, example_of
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect
from shakerproc.models.faults import FAULT_EXAMPLES, AbstractFault
from shakerproc.numerals import numeral
from shakerproc.report.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FREQUENCY: Final = 50.0
"""Frequency of the motion that is drawn [Hz]."""
LARGEST: Final = 1.5e-4
"""Its largest amplitude [m]."""
_SHARES: Final = (1.0, 0.6, 0.3)
_SAMPLES: Final = 2000  # of a cycle
_CYCLES: Final = 3  # the last one is drawn: those before let a memory settle


@final
@dataclass(frozen=True, slots=True, eq=False)
class Cycle:
    """One settled cycle of a prescribed motion, and the force along it.

    Attributes
    ----------
    displacement, velocity, force : (n,) array
        [m], [m/s], [N].
    """

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray

    @property
    def stiffness(self) -> float:
        """Equivalent stiffness: of the force in phase with displacement [N/m]."""
        along = self.displacement
        return float(np.sum(self.force * along) / np.sum(along**2))

    @property
    def damping(self) -> float:
        """Equivalent viscous damping: of the force in phase with velocity [N s/m]."""
        return float(np.sum(self.force * self.velocity) / np.sum(self.velocity**2))


def cycle_of(effect: AbstractEffect, amplitude: float) -> Cycle:
    """Return the last of several cycles of a sine, by the effect's own law.

    `amplitude` is a displacement [m].
    """
    # Half a sample late, so that none falls on a turning point, where a velocity has no sign.
    angle = 2.0 * np.pi * (np.arange(_CYCLES * _SAMPLES) + 0.5) / _SAMPLES
    omega = 2.0 * np.pi * FREQUENCY
    displacement, velocity = amplitude * np.sin(angle), amplitude * omega * np.cos(angle)
    force = effect.force_along(displacement, velocity, FREQUENCY * _SAMPLES)
    last = slice((_CYCLES - 1) * _SAMPLES, None)
    return Cycle(displacement[last], velocity[last], force[last])


def picture(kind: str) -> "Figure":
    """Return the picture of an effect or a fault, with the numbers of its example.

    Raises
    ------
    KeyError
        If there is no such kind.
    """
    if kind in FAULTS:
        return _fault_picture(FAULT_EXAMPLES[kind])
    effect = example_of(kind)
    if isinstance(effect, AttachedMode):
        return _attached_picture(effect)
    if isinstance(effect, StiffnessDrift):
        return _drift_picture(effect)
    return _law_picture(effect)


def numbers(kind: str) -> str:
    """Return the numbers that a picture is drawn with, such as ``k = 1.2e+05 N/m``."""
    return _numbers_of(example_of(kind) if kind in EFFECTS else FAULT_EXAMPLES[kind])


def _shown(value: object) -> str:
    """Return a word as it is, numbers by the first and the last of them."""
    if not isinstance(value, tuple):
        return str(value)
    flat = [one for row in value for one in (row if isinstance(row, tuple) else (row,))]
    return f"{flat[0]:g} ... {flat[-1]:g}"


def _numbers_of(made: AbstractEffect | AbstractFault) -> str:
    shown = []
    for name, parameter in made.parameters.items():
        value = getattr(made, name)
        if value is not None:
            unit = "" if parameter.unit == "1" or parameter.choices else f" {parameter.unit}"
            if parameter.holds == "effects":
                shown += [f"{one.kind}: {_numbers_of(one)}" for one in value]
                continue
            text = f"{value:g}" if isinstance(value, float | int) else _shown(value)
            shown.append(f"{parameter.symbol} = {text}{unit}")
    return ", ".join(shown)


def _panels(kind: str, formula: str) -> tuple["Figure", "Axes", "Axes"]:
    figure = style.notebook_figure()(figsize=(8.0, 3.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    figure.suptitle(f"{kind}:  {formula}\n{numbers(kind)}", fontsize=9.0, x=0.01, ha="left")
    return figure, left, right


def _law_picture(effect: AbstractEffect) -> "Figure":
    figure, left, right = _panels(effect.kind, effect.formula)
    by_velocity = _of_velocity_alone(effect)
    for i, share in enumerate(_SHARES):
        cycle = cycle_of(effect, share * LARGEST)
        along = cycle.velocity if by_velocity else 1e3 * cycle.displacement
        closed = np.append(np.arange(along.size), 0)
        amplitude = 1e3 * share * LARGEST
        left.plot(
            along[closed],
            cycle.force[closed],
            **style.line(i),
            label=f"{numeral(amplitude)} mm",
        )
    left.set_xlabel("velocity [m/s]" if by_velocity else "displacement [mm]")
    left.set_ylabel("force [N]")
    _legend(left, f"amplitude at {FREQUENCY:g} Hz")
    _draw_equivalents(effect, right)
    return figure


def _legend(axis: "Axes", title: str) -> None:
    """Write the legend below the axis, where no line runs."""
    axis.legend(
        title=title,
        title_fontsize=7.5,
        ncols=3,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.16),
        borderaxespad=0.0,
    )


def _of_velocity_alone(effect: AbstractEffect) -> bool:
    """Return whether the force of a law without memory is one curve over velocity."""
    if not isinstance(effect, AbstractMemorylessEffect):
        return False
    velocity = np.linspace(-0.05, 0.05, 41)
    here, there = (
        effect.force_at(np.full_like(velocity, place), velocity) for place in (0.0, LARGEST)
    )
    return bool(np.any(here != 0.0) and np.array_equal(here, there))


def _draw_equivalents(effect: AbstractEffect, axis: "Axes") -> None:
    """Draw equivalent stiffness and damping over amplitude."""
    amplitude = np.linspace(0.02, 1.0, 60) * LARGEST
    cycles = [cycle_of(effect, float(one)) for one in amplitude]
    stiffness = np.array([cycle.stiffness for cycle in cycles])
    damping = np.array([cycle.damping for cycle in cycles])
    omega = 2.0 * np.pi * FREQUENCY
    largest = max(
        float(np.max(np.abs(c.force))) / float(np.max(c.displacement)) for c in cycles
    )
    elastic = float(np.max(np.abs(damping))) * omega < 1e-3 * largest
    viscous = float(np.max(np.abs(stiffness))) < 1e-3 * largest
    if elastic and viscous:  # as far as one harmonic sees, nothing is there
        _draw_mean_force(axis, amplitude, cycles)
        return
    axis.set_xlabel("amplitude [mm]")
    if not viscous:
        axis.plot(1e3 * amplitude, stiffness, **style.line(0), label="stiffness")
        axis.set_ylabel("equivalent stiffness [N/m]", color=style.COLOURS[0])
        _from_zero(axis, stiffness)
    if elastic:
        return
    other = axis if viscous else axis.twinx()
    other.plot(1e3 * amplitude, damping, **style.line(1), label="damping")
    other.set_ylabel("equivalent damping [N s/m]", color=style.COLOURS[1])
    other.grid(visible=viscous)
    other.spines["right"].set_visible(not viscous)
    _from_zero(other, damping)


def _draw_mean_force(axis: "Axes", amplitude: FloatArray, cycles: list[Cycle]) -> None:
    """Draw mean and second harmonic of the force, where it has no first one."""
    spectra = [np.fft.rfft(cycle.force) / cycle.force.size for cycle in cycles]
    for i, (name, values) in enumerate((
        ("mean", [abs(one[0]) for one in spectra]),
        ("second harmonic", [2.0 * abs(one[2]) for one in spectra]),
    )):
        axis.plot(1e3 * amplitude, values, **style.line(i), label=name)
    axis.set_xlabel("amplitude [mm]")
    axis.set_ylabel("force [N]")
    axis.legend()


def _from_zero(axis: "Axes", values: FloatArray) -> None:
    """Let an axis begin at 0, so that a constant looks constant."""
    top = float(np.max(values))
    if top > 0.0 and np.min(values) >= -1e-6 * top:
        axis.set_ylim(0.0, 1.1 * top)
    else:
        size = float(np.max(np.abs(values))) or 1.0
        axis.set_ylim(-1.1 * size, 1.1 * size)


def _attached_picture(effect: AttachedMode) -> "Figure":
    """Draw the apparent mass of an attached mode: the same at every level."""
    figure, left, right = _panels(effect.kind, effect.formula)
    frequency = np.linspace(0.02, 2.0, 800) * effect.frequency
    apparent = effect.apparent_mass(frequency)
    left.plot(frequency, 1e3 * np.abs(apparent), **style.line(0))
    left.set_yscale("log")
    left.set_ylabel("force over acceleration of its place [g]")
    right.plot(frequency, np.degrees(np.unwrap(np.angle(apparent))), **style.line(0))
    right.set_ylabel("phase of that [degrees]")
    for axis in (left, right):
        axis.set_xlabel("frequency [Hz]")
    return figure


def _drift_picture(effect: StiffnessDrift) -> "Figure":
    """Draw how stiffness drifts with time, and the loops at three times."""
    figure, left, right = _panels(effect.kind, effect.formula)
    base = effect.in_place(1.2e5, 1.0) if effect.stiffness is None else effect
    stiffness = base.stiffness or 1.2e5
    displacement = np.array([-LARGEST, LARGEST])
    for i, time in enumerate((0.0, 60.0, 120.0)):
        total = stiffness * (1.0 + effect.rate * (time - effect.reference))
        label = f"after {time:g} s"
        left.plot(1e3 * displacement, total * displacement, **style.line(i), label=label)
    left.set_xlabel("displacement [mm]")
    left.set_ylabel("force of spring and drift [N]")
    _legend(left, "")
    times = np.linspace(0.0, 120.0, 50)
    change = np.sqrt(1.0 + effect.rate * (times - effect.reference))
    right.plot(times, 100.0 * (change - 1.0), **style.line(0))
    right.set_xlabel("time [s]")
    right.set_ylabel("change of the resonance [%]")
    return figure


def _fault_picture(fault: AbstractFault) -> "Figure":
    """Draw a true signal and its recording: in time, and their difference by frequency."""
    figure, left, right = _panels(fault.kind, f"u becomes {fault.formula}")
    rate, n = 200_000.0, 200_000
    time = np.arange(n) / rate
    # A resonance that swells and fades, large enough to be clipped.
    true = 80.0 * np.sin(2.0 * np.pi * 240.0 * time) * np.sin(np.pi * time) ** 2
    recorded = fault.apply(true, rate)
    first, length = n // 2, 0.001 if fault.kind == "sensor_delay" else 0.012
    near = slice(first, first + round(length * rate))
    for i, (name, samples) in enumerate((("true", true), ("recorded", recorded))):
        left.plot(
            1e3 * time[near] - 1e3 * time[first], samples[near], **style.line(i), label=name
        )
    left.set_xlabel("time [ms]")
    left.set_ylabel("acceleration [m/s²]")
    _legend(left, "")
    if fault.kind in {"clipping", "mains_hum"}:
        _draw_spectra(right, true, recorded, rate)
    else:
        _draw_transfer(right, fault, rate, n)
    return figure


def _draw_spectra(axis: "Axes", true: FloatArray, recorded: FloatArray, rate: float) -> None:
    n = true.size
    for i, samples in enumerate((true, recorded)):
        spectrum = np.abs(np.fft.rfft(samples * np.hanning(n))) * 4.0 / n
        axis.semilogy(np.fft.rfftfreq(n, 1.0 / rate), spectrum, **style.line(i))
    axis.set_xlim(0.0, 1500.0)
    axis.set_ylim(1e-3, 200.0)
    axis.set_xlabel("frequency [Hz]")
    axis.set_ylabel("amplitude [m/s²]")


def _draw_transfer(axis: "Axes", fault: AbstractFault, rate: float, n: int) -> None:
    """Draw gain and phase of the recorded over the true signal."""
    impulse = np.zeros(n)
    impulse[n // 2] = 1.0
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    shown = (frequency > 0.0) & (frequency < 2000.0)
    over = (np.fft.rfft(fault.apply(impulse, rate)) / np.fft.rfft(impulse))[shown]
    axis.plot(frequency[shown], np.abs(over), **style.line(0))
    axis.set_ylim(0.0, 1.5)
    axis.set_xlabel("frequency [Hz]")
    axis.set_ylabel("gain [-]", color=style.COLOURS[0])
    other = axis.twinx()
    other.plot(frequency[shown], np.abs(np.degrees(np.angle(over))), **style.line(1))
    other.set_ylim(0.0, 190.0)
    other.set_ylabel("phase, either way [degrees]", color=style.COLOURS[1])
    other.grid(visible=False)
    other.spines["right"].set_visible(True)
