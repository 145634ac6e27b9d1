"""Time history and phase plane of runs."""

from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np

from shakerproc.studies.kinds.base import AbstractKind, Job, label_of, said
from shakerproc.studies.kinds.grid import driven
from shakerproc.studies.results import Columns, Line, Panel, StudyResult
from shakerproc.studies.simulated import simulated
from shakerproc.studies.study import Study

MOST_SHOWN = 20_000


@final
class MotionKind(AbstractKind):
    """The motion of every combination."""

    needs: ClassVar[tuple[str, ...]] = ("model", "run")

    def compute(self, study: Study, job: Job) -> Columns:
        motion = simulated(*job.require())
        return {
            "time_s": motion.time,
            "displacement_m": motion.displacement,
            "velocity_m_per_s": motion.velocity,
            "growth": np.full(motion.time.size, motion.growth),
        }

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        history, plane = [], []
        for i, (job, one) in enumerate(zip(jobs, found, strict=True)):
            step = max(1, one["time_s"].size // MOST_SHOWN)
            time, x, v = (
                one[name][::step].astype(np.float64)
                for name in ("time_s", "displacement_m", "velocity_m_per_s")
            )
            history.append(Line(time, x, label_of(study, job), "line", i))
            plane.append(Line(x, v, "", "line", i))
        statement, verdict = said(study.claim)
        growth = float(np.max([one["growth"][0] for one in found]))
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns={
                "run": np.repeat(np.arange(len(found)), [f["time_s"].size for f in found]),
                **{name: np.concatenate([f[name] for f in found]) for name in found[0]},
            },
            panels=(
                Panel("time [s]", "displacement [m]", tuple(history)),
                Panel("displacement [m]", "velocity [m/s]", tuple(plane), square=True),
            ),
            method=f"{driven(study)}; a disturbance of 1e-10 grew {growth:.3g} times",
            statement=statement,
            verdict=verdict,
        )
