"""Densities of runs side by side: the thesis' PSD figures."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.studies.estimators import Spectrum, in_words, peak_frequency, spectrum
from shakerproc.studies.kinds.base import AbstractKind, Drawing, JobFinding, StudyJob, label_of
from shakerproc.studies.kinds.driving import driven
from shakerproc.studies.motion_readings import (
    half_cycle_scatter,
    half_energy_bins,
    read_run,
    share_at,
)
from shakerproc.studies.results import Columns, StudyLine, StudyPanel
from shakerproc.studies.simulated import SimulatedMotion
from shakerproc.studies.study import Study

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
