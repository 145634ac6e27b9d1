"""Densities of runs side by side: the thesis' PSD figures."""

from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np

from shakerproc.studies.estimators import Spectrum, in_words, omega_e, spectrum
from shakerproc.studies.kinds.base import AbstractKind, Job, label_of, said
from shakerproc.studies.kinds.grid import driven
from shakerproc.studies.results import Columns, Line, Panel, StudyResult
from shakerproc.studies.simulated import simulated
from shakerproc.studies.study import Study

UNITS = {"acceleration": "(m/s²)²/Hz", "velocity": "(m/s)²/Hz", "displacement": "m²/Hz"}


@final
class Spectra(AbstractKind):
    """The density of every combination."""

    needs: ClassVar[tuple[str, ...]] = ("model", "run")

    def compute(self, study: Study, job: Job) -> Columns:
        motion = simulated(*job.require())
        found = spectrum(motion.of(study.measure.of), motion.sample_rate, study.measure)
        shown = found.frequency <= (study.measure.to_hz or np.inf)
        return {
            "frequency_hz": found.frequency[shown],
            "density": found.density[shown],
            "bin_width_hz": np.full(int(shown.sum()), found.bin_width),
        }

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        lines, peaks = [], []
        for i, (job, one) in enumerate(zip(jobs, found, strict=True)):
            width = float(one["bin_width_hz"][0])
            density = Spectrum(
                one["frequency_hz"].astype(np.float64), one["density"].astype(np.float64), width
            )
            peaks.append(omega_e(density, study.measure))
            label = label_of(study, job)
            named = f"{label}: {peaks[-1]:.4g} Hz" if label else f"{peaks[-1]:.4g} Hz"
            lines.append(Line(density.frequency[1:], density.density[1:], named, "line", i))
        width = float(np.max(found[0]["bin_width_hz"].astype(np.float64)))
        columns = {
            "run": np.repeat(np.arange(len(found)), [f["density"].size for f in found]),
            **{name: np.concatenate([f[name] for f in found]) for name in found[0]},
        }
        statement, verdict = said(study.claim)
        panel = Panel(
            "frequency [Hz]", f"PSD [{UNITS[study.measure.of]}]", tuple(lines), log_y=True
        )
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=columns,
            panels=(panel,),
            method=f"{in_words(study.measure, width)}; {driven(study)}",
            statement=statement,
            verdict=verdict,
        )
