"""Grids of parameters in, tables out: the figures of the thesis' chapters 3, 4, 5 and 6."""

from shakerproc.studies.reading import read_study
from shakerproc.studies.results import Columns, StudyImage, StudyLine, StudyPanel, StudyResult
from shakerproc.studies.running import run_study
from shakerproc.studies.study import Measure, Study, StudyRun, Variation

__all__ = [
    "Columns",
    "Measure",
    "Study",
    "StudyImage",
    "StudyLine",
    "StudyPanel",
    "StudyResult",
    "StudyRun",
    "Variation",
    "read_study",
    "run_study",
]
