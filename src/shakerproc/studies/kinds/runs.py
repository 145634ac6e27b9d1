"""Motion against time, in phase planes and Poincaré maps, and densities of runs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.simulation.inputs import MOST_SAMPLES
from shakerproc.spectra import spectrogram
from shakerproc.studies.kinds.base import (
    AbstractKind,
    Drawing,
    JobFinding,
    Option,
    StudyJob,
    column_of,
    driven,
    label_of,
    sine_start,
)
from shakerproc.studies.readings import (
    SimulatedMotion,
    Spectrum,
    chaotic_in_steady_state,
    decay,
    distortion,
    excitation_of,
    half_cycle_scatter,
    half_cycles,
    half_energy_bins,
    in_words,
    peak_frequency,
    period_of,
    read_run,
    share_at,
    simulated,
    spectrum,
    strobe,
)
from shakerproc.studies.results import Columns, StudyImage, StudyLine, StudyPanel
from shakerproc.studies.study import Study, StudyRun, check_run, samples_left

MOST_SHOWN = 20_000

PERIODS: Final = Option("1", least=1, most=MOST_SAMPLES / 360.0, whole=True)

SETTLING: Final = Option("1", most=MOST_SAMPLES / 360.0, whole=True)

QUANTITIES: Final[Mapping[str, str]] = MappingProxyType({
    "period": "1",
    "growth": "1",
    "chaotic": "1",
})


@final
class MotionKind(AbstractKind):
    """The motion of every combination."""

    needs: ClassVar[tuple[str, ...]] = ("model", "run")
    averages: ClassVar[bool] = True
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "largest_m": "m",
        "rms_over_free": "1",
        "decay": "1",
        "distortion": "1",
        "first_cycle_hz": "Hz",
        "last_cycle_hz": "Hz",
        "half_cycle_scatter": "1",
        "growth": "1",
        "chaotic": "1",
    })

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        free = _rms_without_excitation(model, run)

        def read(motion: SimulatedMotion) -> dict[str, float]:
            cycles = 0.5 / half_cycles(motion.time, motion.displacement)
            return {
                "largest_m": float(np.max(np.abs(motion.displacement))),
                "rms_over_free": _rms(motion) / free if free > 0.0 else float("nan"),
                "decay": decay(motion),
                "distortion": distortion(motion),
                "first_cycle_hz": float(cycles[0]) if cycles.size else float("nan"),
                "last_cycle_hz": float(cycles[-1]) if cycles.size else float("nan"),
                "half_cycle_scatter": half_cycle_scatter(motion),
            }

        motion, values, errors = read_run(model, run, study.measure.ensemble, read)
        columns = {
            "time_s": motion.time,
            "displacement_m": motion.displacement,
            "velocity_m_per_s": motion.velocity,
            "growth": np.full(motion.time.size, motion.growth),
        }
        return JobFinding(columns, values, errors)

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        history, plane = [], []
        for i, (job, one) in enumerate(zip(jobs, tables, strict=True)):
            step = max(1, one["time_s"].size // MOST_SHOWN)
            time, x, v = (
                one[name][::step].astype(np.float64)
                for name in ("time_s", "displacement_m", "velocity_m_per_s")
            )
            history.append(StudyLine(time, x, label_of(study, job), "line", i))
            plane.append(StudyLine(x, v, "", "line", i))
        growth = float(np.max([one["growth"][0] for one in tables]))
        return Drawing(
            {
                "run": np.repeat(np.arange(len(tables)), [f["time_s"].size for f in tables]),
                **{name: np.concatenate([f[name] for f in tables]) for name in tables[0]},
            },
            (
                StudyPanel("time [s]", "displacement [m]", tuple(history)),
                StudyPanel("displacement [m]", "velocity [m/s]", tuple(plane), square=True),
            ),
            f"{driven(study)}; a disturbance of 1e-10 grew {growth:.3g} times",
        )


def _rms(motion: SimulatedMotion) -> float:
    return float(np.sqrt(np.mean(motion.displacement**2)))


def _rms_without_excitation(model: Model, run: StudyRun) -> float:
    """Return the rms of the motion that the start alone makes [m]; NaN where nothing drives."""
    if run.excitation == "free" or run.method != "exact":
        return float("nan")
    if not (run.initial_displacement or run.initial_velocity):
        return float("nan")
    return _rms(simulated(model, replace(run, excitation="free"), growth=False))


@final
class Bifurcation(AbstractKind):
    """Displacement once a period against a parameter, after the motion has settled."""

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({
        "periods": PERIODS,
        "settle periods": SETTLING,
    })
    needs: ClassVar[tuple[str, ...]] = ("model", "run", "vary")
    quantities: ClassVar[Mapping[str, str]] = QUANTITIES

    def check_job(self, study: Study, job: StudyJob) -> None:
        _check_sine(job)

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        x, v, growth = strobe(
            model,
            run,
            periods=int(study.option("periods", 64)),
            settle=int(study.option("settle periods", 400)),
            phases=1,
        )
        return JobFinding(
            {"displacement_m": x[0], "velocity_m_per_s": v[0]}, _period_sentence(x, v, growth)
        )

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        variation = study.vary[-1]
        counts = [one["displacement_m"].size for one in tables]
        x = np.repeat([job.values[-1] for job in jobs], counts)
        y = np.concatenate([one["displacement_m"] for one in tables]).astype(np.float64)
        unit = "" if variation.unit == "1" else f" [{variation.unit}]"
        return Drawing(
            columns={
                column_of(variation.name, variation.unit): x,
                "displacement_m": y,
                "velocity_m_per_s": np.concatenate([one["velocity_m_per_s"] for one in tables]),
            },
            panels=(
                StudyPanel(
                    f"{variation.name}{unit}",
                    "displacement once a period [m]",
                    (StudyLine(x, y, "", "points"),),
                ),
            ),
            method=(
                f"{counts[0]} periods after {study.option('settle periods', 400):g} to settle, "
                f"each value from the same initial state, the sine begun {_sine_start(study)}"
            ),
        )


@final
class Poincare(AbstractKind):
    """Displacement and velocity once a period, also at a sequence of phases."""

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({
        "periods": PERIODS,
        "settle periods": SETTLING,
        "phases": Option("1", least=1, most=360, whole=True),
    })
    needs: ClassVar[tuple[str, ...]] = ("model", "run")
    quantities: ClassVar[Mapping[str, str]] = QUANTITIES

    def check_job(self, study: Study, job: StudyJob) -> None:
        _check_sine(job)

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        phases = int(study.option("phases", 1))
        x, v, growth = strobe(
            model,
            run,
            periods=int(study.option("periods", 2000)),
            settle=int(study.option("settle periods", 200)),
            phases=phases,
        )
        columns = {
            "phase_deg": np.repeat(np.arange(phases) * (360.0 / phases), x.shape[1]),
            "displacement_m": x.ravel(),
            "velocity_m_per_s": v.ravel(),
        }
        return JobFinding(columns, _period_sentence(x, v, growth))

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        panels = []
        for job, one in zip(jobs, tables, strict=True):
            for phase in np.unique(one["phase_deg"].astype(np.float64)):
                panels.append(_map(study, job, one, float(phase)))
        return Drawing(
            columns={
                "run": np.repeat(np.arange(len(tables)), [f["phase_deg"].size for f in tables]),
                **{name: np.concatenate([f[name] for f in tables]) for name in tables[0]},
            },
            panels=tuple(panels),
            method=(
                f"{study.option('periods', 2000):g} periods, "
                f"the sine begun {_sine_start(study)}"
            ),
        )


def _check_sine(job: StudyJob) -> None:
    """Pass a run of a sine, which has periods.

    Raises
    ------
    ValueError
        If it is driven by something else.
    """
    _, run = job.require()
    check_run(run)
    if run.excitation != "sine":
        raise ValueError(f"looking once a period needs a sine, not {run.excitation}")


def _period_sentence(x: FloatArray, v: FloatArray, growth: float) -> dict[str, float]:
    """Return after how many periods the motion comes back, and whether it is chaotic."""
    period = period_of(x[0], v[0])
    return {
        "period": period,
        "growth": growth,
        "chaotic": float(chaotic_in_steady_state(growth, period)),
    }


def _sine_start(study: Study) -> str:
    return sine_start(0.0 if study.run is None else study.run.phase)


def _map(study: Study, job: StudyJob, one: Columns, phase: float) -> StudyPanel:
    here = one["phase_deg"].astype(np.float64) == phase
    x: FloatArray = one["displacement_m"][here].astype(np.float64)
    v: FloatArray = one["velocity_m_per_s"][here].astype(np.float64)
    label = label_of(study, job)
    title = f"{label}, phase {phase:g}°" if label else f"phase {phase:g}°"
    return StudyPanel(
        "displacement [m]",
        "velocity [m/s]",
        (StudyLine(x, v, "", "points"),),
        title,
        square=True,
    )


UNITS = {"acceleration": "(m/s²)²/Hz", "velocity": "(m/s)²/Hz", "displacement": "m²/Hz"}


@final
class Spectra(AbstractKind):
    """The density of every combination."""

    needs: ClassVar[tuple[str, ...]] = ("model", "run")
    averages: ClassVar[bool] = True
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "peak_frequency_hz": "Hz",
        "peak_over_forcing": "1",
        "share_at_forcing": "1",
        "half_energy_bins": "1",
        "half_cycle_scatter": "1",
        "growth": "1",
        "chaotic": "1",
    })

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        forcing = run.frequency if run.excitation == "sine" else float("nan")

        def read(motion: SimulatedMotion) -> dict[str, float]:
            whole = spectrum(motion.of(study.measure.of), motion.sample_rate, study.measure)
            peak = peak_frequency(whole, study.measure)
            return {
                "peak_frequency_hz": peak,
                "peak_over_forcing": peak / forcing if forcing > 0.0 else float("nan"),
                "share_at_forcing": share_at(whole, forcing),
                "half_energy_bins": half_energy_bins(whole),
                "half_cycle_scatter": half_cycle_scatter(motion),
            }

        motion, values, errors = read_run(model, run, study.measure.ensemble, read)
        lines = spectrum(motion.of(study.measure.of), motion.sample_rate, study.measure)
        shown = lines.frequency <= (study.measure.to_hz or np.inf)
        columns = {
            "frequency_hz": lines.frequency[shown],
            "density": lines.density[shown],
            "bin_width_hz": np.full(int(shown.sum()), lines.bin_width),
        }
        finest = {"peak_frequency_hz": lines.bin_width, "half_energy_bins": 1.0}
        if forcing > 0.0:
            finest["peak_over_forcing"] = lines.bin_width / forcing
        return JobFinding(columns, values, {**finest, **errors})

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        lines = []
        for i, (job, one) in enumerate(zip(jobs, tables, strict=True)):
            width = float(one["bin_width_hz"][0])
            density = Spectrum(
                one["frequency_hz"].astype(np.float64), one["density"].astype(np.float64), width
            )
            peak = peak_frequency(density, study.measure)
            label = label_of(study, job)
            named = f"{label}: {peak:.4g} Hz" if label else f"{peak:.4g} Hz"
            lines.append(
                StudyLine(density.frequency[1:], density.density[1:], named, "line", i)
            )
        width = float(np.max(tables[0]["bin_width_hz"].astype(np.float64)))
        columns = {
            "run": np.repeat(np.arange(len(tables)), [f["density"].size for f in tables]),
            **{name: np.concatenate([f[name] for f in tables]) for name in tables[0]},
        }
        panel = StudyPanel(
            "frequency [Hz]", f"PSD [{UNITS[study.measure.of]}]", tuple(lines), log_y=True
        )
        return Drawing(columns, (panel,), f"{in_words(study.measure, width)}; {driven(study)}")


@final
class SpectrogramKind(AbstractKind):
    """Spectrogram of one run; option ``of excitation`` (1) for that of the excitation."""

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({
        "of excitation": Option("1", most=1, whole=True),
        "segment": Option("1", least=16, whole=True),
        "to": Option("Hz"),
    })
    needs: ClassVar[tuple[str, ...]] = ("model", "run")

    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "ridge_start_hz": "Hz",
        "ridge_end_hz": "Hz",
        "ridge_departure_hz": "Hz",
        "growth": "1",
        "chaotic": "1",
    })

    def check_job(self, study: Study, job: StudyJob) -> None:
        _, run = job.require()
        check_run(run)
        segment = study.option("segment", 256)
        if segment > samples_left(run):
            raise ValueError(
                f"a run of {samples_left(run):g} samples holds no segment of {segment:g}"
            )

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        quantities = {"growth": float("nan"), "chaotic": 0.0}
        if study.option("of excitation", 0.0):
            samples = excitation_of(run)
        else:
            motion = simulated(model, run)
            samples = motion.of(study.measure.of)
            quantities = {"growth": motion.growth, "chaotic": float(motion.chaotic)}
        surface = spectrogram(
            samples[None], run.sample_rate, segment=int(study.option("segment", 256))
        )
        shown = surface.frequency <= study.option("to", np.inf)
        density = surface.density[0][shown]
        columns = {
            "time_s": np.tile(surface.time, int(shown.sum())),
            "frequency_hz": np.repeat(surface.frequency[shown], surface.time.size),
            "density": density.ravel(),
        }
        tallest = surface.frequency[shown][np.argmax(density, axis=0)]
        ridge = _ridge(surface.time, tallest, samples.size / run.sample_rate)
        finest = dict.fromkeys(ridge, float(surface.frequency[1] - surface.frequency[0]))
        return JobFinding(columns, {**ridge, **quantities}, finest)

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        columns = tables[0]
        time = np.unique(columns["time_s"].astype(np.float64))
        frequency = np.unique(columns["frequency_hz"].astype(np.float64))
        density = columns["density"].astype(np.float64).reshape(frequency.size, time.size)
        image = StudyImage(time, frequency, density)
        panel = StudyPanel("time [s]", "frequency [Hz]", (), image=image)
        return Drawing(columns, (panel,), driven(study))


def _ridge(time: FloatArray, tallest: FloatArray, duration: float) -> dict[str, float]:
    """Return the straight line through the tallest frequencies, and how far they leave it."""
    slope, start = np.polyfit(time, tallest, 1) if time.size > 1 else (0.0, tallest[0])
    return {
        "ridge_start_hz": float(start),
        "ridge_end_hz": float(start + slope * duration),
        "ridge_departure_hz": float(np.max(np.abs(tallest - start - slope * time))),
    }
