"""Time history and phase plane of runs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.models import Model
from shakerproc.studies.kinds.base import AbstractKind, Drawing, JobFinding, StudyJob, label_of
from shakerproc.studies.kinds.driving import driven
from shakerproc.studies.motion_readings import (
    decay,
    distortion,
    half_cycle_scatter,
    half_cycles,
    read_run,
)
from shakerproc.studies.results import Columns, StudyLine, StudyPanel
from shakerproc.studies.simulated import SimulatedMotion, simulated
from shakerproc.studies.study import Study, StudyRun

MOST_SHOWN = 20_000


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
        self, study: Study, jobs: Sequence[StudyJob], found: Sequence[Columns]
    ) -> Drawing:
        history, plane = [], []
        for i, (job, one) in enumerate(zip(jobs, found, strict=True)):
            step = max(1, one["time_s"].size // MOST_SHOWN)
            time, x, v = (
                one[name][::step].astype(np.float64)
                for name in ("time_s", "displacement_m", "velocity_m_per_s")
            )
            history.append(StudyLine(time, x, label_of(study, job), "line", i))
            plane.append(StudyLine(x, v, "", "line", i))
        growth = float(np.max([one["growth"][0] for one in found]))
        return Drawing(
            {
                "run": np.repeat(np.arange(len(found)), [f["time_s"].size for f in found]),
                **{name: np.concatenate([f[name] for f in found]) for name in found[0]},
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
