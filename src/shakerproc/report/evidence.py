"""The evidence of a comparison and a diagnosis as sections of the report."""

import base64
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from markupsafe import Markup

from shakerproc.compare import Comparison, sentence
from shakerproc.diagnose import Diagnosis
from shakerproc.report import svg
from shakerproc.report.page import Section, Table
from shakerproc.report.run_view import Drawing

CAPTIONS: Final[Mapping[str, tuple[str, str]]] = {
    "response": (
        "Measured and modelled response.",
        "Where the lines part, the model fails; look whether it depends on the level.",
    ),
    "error_map": (
        "Error over frequency and level.",
        "An error that grows with level is a missing nonlinearity.",
    ),
    "restoring_force": (
        "Restoring force.",
        "Against displacement and velocity: the shape of what holds the mass.",
    ),
    "error_in_time": ("Error in time.", "A drift shows as a slope."),
    "harmonics": ("Harmonics.", "Energy where the table does not shake."),
}


def picture(path: Path, title: str, caption: str) -> Drawing:
    """Return a PNG file as a drawing that is part of the page."""
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    image = Markup('<img alt="{}" src="data:image/png;base64,{}">').format(title, data)
    return Drawing(title, caption, image)


def comparison_section(
    comparison: Comparison, figures: Sequence[Path], title: str, anchor: str
) -> Section:
    """Return where a model fails: a sentence, the errors of every test, the figures."""
    rows = [
        (
            test.measured.name,
            test.measured.test.level_text,
            "yes" if test.measured.test.hold_out else "",
            f"{test.error:.1%}",
            f"{test.noise:.2%}",
            "" if test.prediction.predictable else "chaotic: judged by density and H1",
        )
        for test in comparison.tests
    ]
    columns = ("test", "level", "held out", "not explained", "noise", "note")
    table = Table(
        "Share of the measured response that the model does not explain", columns, rows
    )
    return Section(
        title, anchor, [sentence(comparison)], [table], [_captioned(path) for path in figures]
    )


def _captioned(path: Path) -> Drawing:
    key = next((name for name in CAPTIONS if path.stem.startswith(name)), "")
    return picture(path, *CAPTIONS.get(key, (path.stem.replace("_", " "), "")))


def diagnosis_section(diagnosis: Diagnosis) -> Section:
    """Return which effect is missing: verdict, error ladder, parameters, what was tried."""
    found = [
        (effect.kind, " - ".join(effect.between), name, _number(p.value), _number(p.low),
         _number(p.high), p.unit)
        for effect in diagnosis.effects
        for name, p in effect.parameters.items()
    ]  # fmt: skip
    tried = [
        (
            c.kind,
            " - ".join(c.between),
            _number(c.fitted_error),
            _number(c.held_out_error) or "left behind",
        )
        for c in diagnosis.candidates
    ]
    tables = [
        Table(
            "Found, with 95 % intervals",
            ("effect", "between", "parameter", "value", "low", "high", "unit"),
            found,
        ),
        Table(
            "Tried, best first", ("effect", "between", "fitted error", "held-out error"), tried
        ),
    ]
    paragraphs = [f"Verdict: {diagnosis.verdict}. {diagnosis.sentence}"]
    if diagnosis.indistinguishable:
        names = ", ".join(diagnosis.indistinguishable)
        paragraphs.append(f"Cannot be told apart on these tests: {names}.")
    paragraphs += [
        f"Next test: {test.excitation} at {test.level}: {test.reason}"
        for test in diagnosis.next_test
    ]
    used = [table for table in tables if table.rows]
    return Section("What is missing", "diagnosis", paragraphs, used, [ladder(diagnosis)])


def _number(value: float | str | None) -> str:
    if isinstance(value, str):
        return value
    return "" if value is None or not math.isfinite(value) else f"{value:.4g}"


def ladder(diagnosis: Diagnosis) -> Drawing:
    """Return the errors before and after, on fitted and on held-out tests."""
    errors = diagnosis.errors
    places = np.array([0.0, 1.0])
    curves = [
        svg.Curve(name, places, np.array([pair.before, pair.after]), style, points=True)
        for style, (name, pair) in enumerate((
            ("fitted tests", errors.fitted),
            ("held-out tests", errors.held_out),
        ))
    ]
    floor = np.full(2, errors.noise_floor)
    curves.append(svg.Curve("noise floor", np.array([-0.5, 1.5]), floor, 7, thin=True))
    values = np.concatenate([curve.y for curve in curves])
    values = values[np.isfinite(values) & (values > 0.0)]
    low = 10.0 ** np.floor(np.log10(values.min())) if values.size else 0.01
    high = 10.0 ** np.ceil(np.log10(values.max()) + 0.05) if values.size else 1.0
    names = {0.0: "model as it was", 1.0: "with the effect"}
    return Drawing(
        "Error ladder.",
        "Held-out tests took no part in the fit: if theirs falls too, the effect is real.",
        svg.plot(
            curves,
            svg.Axis("", -0.5, 1.5),
            svg.Axis("share not explained [-]", float(low), float(high), logarithmic=True),
            title="Errors before and after",
            names=names,
            height=260,
        ),
    )
