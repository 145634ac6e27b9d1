"""The pages of the effects, made from EFFECTS and FAULTS when the manual is built (a hook).

The decisions, of which there will be more, are put into the navigation as well.
"""

import hashlib
import inspect
import io
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

DOCS = Path(__file__).parent
ROOT = DOCS.parent
OVERVIEW = "<!-- all effects -->"
NOTES = DOCS / "effect_notes.yaml"
MIMICS = DOCS / "effect_mimics.json"
CACHE = ROOT / "build" / "effect_pictures"
DRAWN_FROM = (
    "models/effects",
    "models/faults.py",
    "report/models/effects.py",
)


def on_config(config: "MkDocsConfig") -> "MkDocsConfig":
    """Put the pages into the navigation: of the effects after their overview."""
    from shakerproc.models import EFFECTS, FAULTS

    for entry in config.nav or []:
        if isinstance(entry, dict) and "Effects" in entry:
            entry["Effects"] += [{kind: f"effects/{kind}.md"} for kind in EFFECTS]
            entry["Effects"].append({
                "Faults of the measurement": [{k: f"effects/{k}.md"} for k in FAULTS]
            })
        if isinstance(entry, dict) and "Decisions" in entry:
            entry["Decisions"] = [f"decisions/{path.name}" for path in _decisions()]
    return config


def _decisions() -> list[Path]:
    return sorted((DOCS / "decisions").glob("*.md"))


def on_files(files: "Files", config: "MkDocsConfig") -> "Files":
    """Add a page and a picture for each effect and each fault."""
    from mkdocs.structure.files import File

    for name, content in pages().items():
        files.append(File.generated(config, f"effects/{name}.md", content=content))
    for name, picture in pictures().items():
        files.append(File.generated(config, f"effects/{name}.svg", content=picture))
    return files


def on_page_markdown(
    markdown: str,
    page: "Page",  # noqa: ARG001 - what mkdocs hands over
    config: "MkDocsConfig",  # noqa: ARG001
    files: "Files",  # noqa: ARG001
) -> str:
    """Put the tables of all effects and faults where the overview wants them."""
    return markdown.replace(OVERVIEW, overview()) if OVERVIEW in markdown else markdown


def overview() -> str:
    """Return a table of the effects and one of the faults, with links to their pages."""
    from shakerproc.models import EFFECTS, FAULTS

    lines = []
    for title, kinds in (("effect", EFFECTS), ("fault of the measurement", FAULTS)):
        lines += [f"| {title} | formula | in the data |", "|---|---|---|"]
        for name, kind in kinds.items():
            formula = kind.formula.replace("|", "\\|")
            lines.append(f"| [{name}](effects/{name}.md) | {formula} | {kind.signature} |")
        lines.append("")
    return "\n".join(lines)


def pages() -> dict[str, str]:
    """Return the page of each kind (Markdown)."""
    from shakerproc.workflows.effect_list import known_kinds

    notes = yaml.safe_load(NOTES.read_text(encoding="utf-8"))
    return {name: page_of(name, kind, notes[name]) for name, kind in known_kinds().items()}


def page_of(name: str, kind: Any, notes: dict[str, str]) -> str:
    """Return one page: the same frame for all."""
    from shakerproc.models import FAULTS
    from shakerproc.report.models.effects import numbers
    from shakerproc.workflows.effect_list import document_of

    document: dict[str, Any] = document_of(kind)
    told, formula = paragraphs_of(kind)
    is_fault = name in FAULTS
    lines = [f"# {name}", "", *(text for part in told[:1] for text in (_prose(part), ""))]
    if formula:
        lines += [mathml(formula, block=True), ""]
    lines += [f"    {'recorded = ' if is_fault else ''}{document['formula']}", ""]
    lines += [text for part in told[1:] for text in (_prose(part), "")]
    lines += [
        *_parameters(document["parameters"]),
        "## In the data",
        "",
        document["signature"],
        "",
    ]
    drawn = numbers(name) or "no numbers of its own"
    lines += [f"![{name}]({name}.svg)", "", f"*{_caption(name)} Drawn with {drawn}.*", ""]
    lines += ["## What it is confused with", ""]
    lines += [f"- [{other}]({other}.md): {text}." for other, text in notes.items()]
    lines += ["", *_mimics(name), "## In a model file", "", "```yaml", snippet(name), "```", ""]
    lines += _sought(name, is_fault=is_fault)
    if document["references"]:
        lines += ["## References", "", *(f"- {text}" for text in document["references"])]
    return "\n".join(lines) + "\n"


def paragraphs_of(kind: Any) -> tuple[list[str], str]:
    """Return what the docstring of a kind tells, and its displayed formula (LaTeX)."""
    told = (inspect.getdoc(kind) or "").partition("Attributes\n----------\n")[0]
    told = told.partition("References\n----------\n")[0]
    found = re.search(r"\.\. math::\s*(.*?)(?=\n\s*\n\S|\Z)", told.strip(), re.DOTALL)
    if found is not None:
        told = told.replace(found[0], "")
    formula = " ".join(found[1].split()) if found else ""
    parts = [" ".join(part.split()) for part in told.split("\n\n") if part.strip()]
    return parts, formula


def mathml(formula: str, *, block: bool) -> str:
    """Return a formula as MathML, which browsers show without help from outside."""
    from latex2mathml.converter import convert

    lines = [re.sub(r"\\dot (\w)", r"\\dot{\1}", one) for one in formula.split(r"\\")]
    display = "block" if block else "inline"
    return "\n".join(convert(one.replace("&", "").strip(), display=display) for one in lines)


def _prose(text: str) -> str:
    text = re.sub(r":math:`([^`]*)`", lambda m: mathml(m[1], block=False), text)
    return text.replace("``", "`")


def _parameters(parameters: dict[str, Any]) -> list[str]:
    if not parameters:
        return []
    lines = ["| parameter | symbol | unit | meaning | must be |", "|---|---|---|---|---|"]
    for name, one in parameters.items():
        unit = " or ".join(one["choices"]) or one["unit"].replace("1", "-", one["unit"] == "1")
        must = "" if one["choices"] else one["sign"]
        must += ", may be left out" if one["optional"] else ""
        lines.append(f"| `{name}` | {one['symbol']} | {unit} | {one['meaning']} | {must} |")
    return [*lines, ""]


def _sought(name: str, *, is_fault: bool) -> list[str]:
    """Return how the diagnosis treats a kind, and how to add it by hand."""
    from shakerproc.models import EFFECTS
    from shakerproc.models.own_effects import TYPICAL

    if is_fault:
        return ["`shakerproc diagnose` names it, and does not explain it by physics.", ""]
    if name in {"spring", "damper"}:
        return ["`shakerproc diagnose` and `shakerproc compare --fit` fit it.", ""]
    if EFFECTS[name].identification(TYPICAL) is None:
        return [
            "`shakerproc diagnose` does not look for it: it is there to be compared with.",
            "",
        ]
    return [
        "`shakerproc diagnose` looks for it; where you know better than the diagnosis,",
        "",
        f"    shakerproc add {name} model.yaml testlog.yaml -o with-{name}.yaml",
        "",
        "fits its numbers and writes them into a new model file.",
        "",
    ]


def _mimics(name: str, count: int = 5) -> list[str]:
    """Return a table of the effects whose force comes closest; nothing where none was tried."""
    found = json.loads(MIMICS.read_text(encoding="utf-8")).get(name)
    if found is None:
        return []
    nearest = sorted(found.items(), key=lambda pair: float(pair[1]["three levels"]))[:count]
    lines = [
        "What is left of its force when a spring, a damper and the other effect are fitted to "
        "it, as a share of what spring and damper alone leave (the example above, random "
        "motion; `docs/make_mimics.py`). What leaves 0 % cannot be told apart by such a test:",
        "",
        "| in its place | left, one level | left, three levels a factor of 2 apart |",
        "|---|---|---|",
    ]
    for other, shares in nearest:
        one, three = (f"{100.0 * shares[name]:.1f} %" for name in ("one level", "three levels"))
        lines.append(f"| [{other}]({other}.md) | {one} | {three} |")
    return [*lines, ""]


def _caption(name: str) -> str:
    from shakerproc.models import FAULTS

    if name in FAULTS:
        return "Left the true signal beside what is recorded, right what that does to it."
    if name == "attached_mode":
        return (
            "Force over the acceleration of its place: apparent mass and phase, at any level."
        )
    if name == "stiffness_drift":
        return "Left the force at three times, right how the resonance moves."
    return (
        "Left the force along sines of three amplitudes, right the stiffness and the damping "
        "that the first harmonic sees as the amplitude rises."
    )


def snippet(name: str) -> str:
    """Return how a model file names the kind: a line of its elements, or of its sensors."""
    from shakerproc.model_files.writing import element_text, model_text
    from shakerproc.models import FAULTS, Element, Excitation, Model, Sensor
    from shakerproc.models.effects import EXAMPLES, Spring
    from shakerproc.models.faults import FAULT_EXAMPLES

    between = ("base", "coupon")
    if name not in FAULTS:
        return f"elements:\n  - {element_text(Element(EXAMPLES[name], between))}"
    model = Model(
        title="",
        masses={"coupon": 1.0},
        elements=(Element(Spring(1.0), between),),
        excitation=Excitation("base acceleration"),
        sensors={"ch3": Sensor("coupon", faults=(FAULT_EXAMPLES[name],))},
    )
    return "sensors:" + model_text(model).partition("sensors:")[2].rstrip()


def pictures() -> dict[str, str]:
    """Return the picture of each kind (SVG), drawn afresh only where its sources changed."""
    from shakerproc.workflows.effect_list import known_kinds

    cache = CACHE / _fingerprint()
    if not cache.is_dir():
        _draw_all(cache)
    return {name: (cache / f"{name}.svg").read_text(encoding="utf-8") for name in known_kinds()}


def _fingerprint() -> str:
    """Return a hash of all that the pictures are drawn from."""
    source = ROOT / "src" / "shakerproc"
    found = [source / name for name in (*DRAWN_FROM, "report/figures/style.py")]
    files = [
        f for path in found for f in (sorted(path.glob("*.py")) if path.is_dir() else [path])
    ]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]


def _draw_all(folder: Path) -> None:
    import matplotlib as mpl

    from shakerproc import files
    from shakerproc.report.figures import style
    from shakerproc.report.models.effects import picture
    from shakerproc.workflows.effect_list import known_kinds

    drawn = {}
    with style.look(), mpl.rc_context({"svg.hashsalt": "shakerproc"}):
        for name in known_kinds():
            buffer = io.StringIO()
            picture(name).savefig(buffer, format="svg", metadata={"Date": None})
            drawn[name] = buffer.getvalue()
    for name, text in drawn.items():
        files.write_text(folder / f"{name}.svg", text)
