"""A model compared with measured response functions: `shakerproc compare MODEL FUNCTIONS`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

from shakerproc import __version__, files
from shakerproc.comparison.document import mode_tables, modes_document
from shakerproc.comparison.response_functions import FunctionComparison, compare_functions
from shakerproc.errors import ArgumentError
from shakerproc.models import Model
from shakerproc.recordings.response_functions import read_functions
from shakerproc.report.evidence.functions import function_report
from shakerproc.report.page.page import write_report
from shakerproc.testlog import Modal

SCHEMA: Final = "shakerproc-compare-functions/1"
COLUMNS: Final = (
    "response", "input", "error_percent", "frac", "peak_hz", "model_peak_hz", "coherence",
)  # fmt: skip


@final
@dataclass(frozen=True, slots=True, eq=False)
class ComparedFile:
    """A model beside the response functions of a file.

    Attributes
    ----------
    found : FunctionComparison
        Errors, functions and modes.
    path : Path
        The file.
    """

    found: FunctionComparison
    path: Path

    @property
    def rows(self) -> list[tuple[Any, ...]]:
        """A row for each function, as functions.csv."""
        found = self.found
        return [
            (
                one.response, one.input, 100.0 * one.error, one.frac, found.peak(one.measured),
                found.peak(one.model),
                None if one.coherence is None else float(one.coherence.mean()),
            )
            for one in found.functions
        ]  # fmt: skip

    def as_json(self) -> dict[str, Any]:
        """Return the comparison as compare.json holds it."""
        found = self.found
        return {
            "schema": SCHEMA,
            "version": __version__,
            "model": found.model.title,
            "functions_file": self.path.name,
            "functions_sha256": found.measured.sha256,
            "band_hz": [float(found.frequency[0]), float(found.frequency[-1])],
            "error": found.error,
            "sentence": found.sentence,
            "functions": [dict(zip(COLUMNS, row, strict=True)) for row in self.rows],
            "modes": None if found.modes is None else modes_document(found.modes),
            "notes": list(found.notes),
        }

    def write(self, folder: Path, command: str, inputs: Sequence[tuple[str, str, str]]) -> Path:
        """Write tables and page; return the page."""
        files.write_json(folder / "compare.json", self.as_json())
        table = {name: [row[i] for row in self.rows] for i, name in enumerate(COLUMNS)}
        files.write_csv(folder / "functions.csv", table)
        for name, columns in mode_tables(self.found.modes).items():
            files.write_csv(folder / name, columns)
        page = folder / "report.html"
        write_report(page, function_report(self.found, command, tuple(inputs)))
        return page


def compare_file(
    model: Model, path: Path, at: Sequence[str] = (), band: tuple[float, float] | None = None
) -> ComparedFile:
    """Return a model beside the response functions of a file.

    Parameters
    ----------
    model : Model
        Its linear part is compared.
    path : Path
        UFF, CSV or MAT.
    at : sequence of str
        ``NAME=PLACE``: the sensor or place of the model that a name of the file stands for.
    band : (float, float), optional
        What is compared [Hz]; by default all lines.

    Raises
    ------
    ArgumentError
        If one of `at` is no pair of names.
    """
    measured = read_functions(path)
    return ComparedFile(compare_functions(model, measured, _pairs(at), Modal(band=band)), path)


def _pairs(at: Sequence[str]) -> Mapping[str, str]:
    found = {}
    for one in at:
        name, _, place = one.partition("=")
        if not name.strip() or not place.strip():
            raise ArgumentError("at", f"expected NAME=PLACE, got {one!r}")
        found[name.strip()] = place.strip()
    return found
