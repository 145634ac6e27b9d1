"""Densities of runs: side by side, or against time."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra import spectrogram
from shakerproc.studies.kinds.base import (
    AbstractKind,
    Drawing,
    JobFinding,
    Option,
    StudyJob,
    driven,
    label_of,
)
from shakerproc.studies.readings import (
    SimulatedMotion,
    Spectrum,
    excitation_of,
    half_cycle_scatter,
    half_energy_bins,
    in_words,
    peak_frequency,
    read_run,
    share_at,
    simulated,
    spectrum,
)
from shakerproc.studies.results import Columns, StudyImage, StudyLine, StudyPanel
from shakerproc.studies.study import Study, check_run, samples_left

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
        found = spectrum(motion.of(study.measure.of), motion.sample_rate, study.measure)
        shown = found.frequency <= (study.measure.to_hz or np.inf)
        columns = {
            "frequency_hz": found.frequency[shown],
            "density": found.density[shown],
            "bin_width_hz": np.full(int(shown.sum()), found.bin_width),
        }
        finest = {"peak_frequency_hz": found.bin_width, "half_energy_bins": 1.0}
        if forcing > 0.0:
            finest["peak_over_forcing"] = found.bin_width / forcing
        return JobFinding(columns, values, {**finest, **errors})

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], found: Sequence[Columns]
    ) -> Drawing:
        lines = []
        for i, (job, one) in enumerate(zip(jobs, found, strict=True)):
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
        width = float(np.max(found[0]["bin_width_hz"].astype(np.float64)))
        columns = {
            "run": np.repeat(np.arange(len(found)), [f["density"].size for f in found]),
            **{name: np.concatenate([f[name] for f in found]) for name in found[0]},
        }
        panel = StudyPanel(
            "frequency [Hz]", f"PSD [{UNITS[study.measure.of]}]", tuple(lines), log_y=True
        )
        return Drawing(columns, (panel,), f"{in_words(study.measure, width)}; {driven(study)}")


@final
class SpectrogramKind(AbstractKind):
    """Spectrogram of one run; option ``of excitation`` (1) for what drives it."""

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
        told = {"growth": float("nan"), "chaotic": 0.0}
        if study.option("of excitation", 0.0):
            samples = excitation_of(run)
        else:
            motion = simulated(model, run)
            samples = motion.of(study.measure.of)
            told = {"growth": motion.growth, "chaotic": float(motion.chaotic)}
        found = spectrogram(
            samples[None], run.sample_rate, segment=int(study.option("segment", 256))
        )
        shown = found.frequency <= study.option("to", np.inf)
        density = found.density[0][shown]
        columns = {
            "time_s": np.tile(found.time, int(shown.sum())),
            "frequency_hz": np.repeat(found.frequency[shown], found.time.size),
            "density": density.ravel(),
        }
        tallest = found.frequency[shown][np.argmax(density, axis=0)]
        ridge = _ridge(found.time, tallest, samples.size / run.sample_rate)
        finest = dict.fromkeys(ridge, float(found.frequency[1] - found.frequency[0]))
        return JobFinding(columns, {**ridge, **told}, finest)

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], found: Sequence[Columns]
    ) -> Drawing:
        columns = found[0]
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
