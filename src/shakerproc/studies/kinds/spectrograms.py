"""Density against time: of the excitation, or of the motion."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra import spectrogram
from shakerproc.studies.kinds.base import AbstractKind, Drawing, JobFinding, Option, StudyJob
from shakerproc.studies.kinds.driving import driven
from shakerproc.studies.results import Columns, StudyImage, StudyPanel
from shakerproc.studies.run_validation import check_run, samples_left
from shakerproc.studies.simulated import excitation_of, simulated
from shakerproc.studies.study import Study


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
