"""Density against time: of the excitation, or of the motion."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.spectra import spectrogram
from shakerproc.studies.kinds.base import AbstractKind, Job, said
from shakerproc.studies.kinds.grid import driven
from shakerproc.studies.results import Columns, Image, Panel, StudyResult
from shakerproc.studies.simulated import excitation_of, simulated
from shakerproc.studies.study import Study


@final
class SpectrogramKind(AbstractKind):
    """Spectrogram of one run; option ``of excitation`` (1) for what drives it."""

    options: ClassVar[Mapping[str, str]] = MappingProxyType({
        "of excitation": "1",
        "segment": "1",
        "to": "Hz",
    })
    needs: ClassVar[tuple[str, ...]] = ("model", "run")

    def compute(self, study: Study, job: Job) -> Columns:
        model, run = job.require()
        if study.option("of excitation", 0.0):
            samples = excitation_of(run)
        else:
            samples = simulated(model, run).of(study.measure.of)
        found = spectrogram(
            samples[None], run.sample_rate, segment=int(study.option("segment", 256))
        )
        shown = found.frequency <= study.option("to", np.inf)
        density = found.density[0][shown]
        return {
            "time_s": np.tile(found.time, int(shown.sum())),
            "frequency_hz": np.repeat(found.frequency[shown], found.time.size),
            "density": density.ravel(),
        }

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        columns = found[0]
        time = np.unique(columns["time_s"].astype(np.float64))
        frequency = np.unique(columns["frequency_hz"].astype(np.float64))
        density = columns["density"].astype(np.float64).reshape(frequency.size, time.size)
        statement, verdict = said(study.claim)
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=columns,
            panels=(
                Panel("time [s]", "frequency [Hz]", (), image=Image(time, frequency, density)),
            ),
            method=driven(study),
            statement=statement,
            verdict=verdict,
        )
