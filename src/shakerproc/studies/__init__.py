"""Grids of parameters in, tables out: the figures of the thesis' chapters 3, 4, 5 and 6."""

from shakerproc.studies.reading import read_study
from shakerproc.studies.results import Columns, Image, Line, Panel, StudyResult
from shakerproc.studies.running import run_study
from shakerproc.studies.study import Measure, Run, Study, Variation

__all__ = [
    "Columns",
    "Image",
    "Line",
    "Measure",
    "Panel",
    "Run",
    "Study",
    "StudyResult",
    "Variation",
    "read_study",
    "run_study",
]
