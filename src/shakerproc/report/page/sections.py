"""Parts of the page: its head, sections with tables and figures, templates of a user's own."""

import base64
import ctypes
import io
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from jinja2 import (
    DictLoader,
    Environment,
    PackageLoader,
    StrictUndefined,
    TemplateError,
    TemplateNotFound,
    nodes,
)
from jinja2.loaders import ChoiceLoader
from jinja2.sandbox import MAX_RANGE, ImmutableSandboxedEnvironment
from markupsafe import Markup

from shakerproc.errors import LogError
from shakerproc.executors import limited_memory
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.summary import RunSummary
from shakerproc.testlog import TestLog
from shakerproc.units import quoted

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile


@dataclass(frozen=True, slots=True)
class PageFigure:
    """A figure with its caption.

    Attributes
    ----------
    title, caption : str
        What it is, and what to look for.
    drawing : Markup
        The figure.
    kind : str
        Of the curves of a run, so that those of several can be overlaid.
    broad : bool
        Whether it takes the whole width.
    paper : bool
        Whether it is printed with the page.
    """

    title: str
    caption: str
    drawing: Markup
    kind: str = ""
    broad: bool = False
    paper: bool = True


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A table of a further section: cells are text already."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, slots=True)
class ReportSection:
    """A further section of the report, such as the evidence of a diagnosis.

    Attributes
    ----------
    title, anchor : str
        Its heading, and what the navigation calls it.
    paragraphs, tables, figures, parts : sequence
        What it holds, in this order; parts are sections of their own.
    """

    title: str
    anchor: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[ReportTable] = ()
    figures: Sequence[PageFigure] = ()
    parts: "Sequence[ReportSection]" = ()


def filled(caption: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> ReportTable:
    """Return a table without the columns that hold nothing."""
    kept = [i for i, _ in enumerate(columns) if any(row[i] for row in rows)]
    return ReportTable(
        caption, [columns[i] for i in kept], [[row[i] for i in kept] for row in rows]
    )


BASE: Final = "report.html.j2"
"""Our template, which a user's own extends: head and security policy stay ours."""

MOST_MEMORY: Final = 1_000_000_000
"""What a template of a log may take beside what is there already [byte]."""

MOST_SECONDS: Final = 20.0
"""How long a template of a log may take [s]; a page of a thousand runs takes some seconds."""

LARGEST_FACTOR: Final = 1 << 53
"""Largest whole number that a product takes as it is: a floating-point number is as exact."""

_OWN: Final = "own"
_FROM_TEXT: Final = "<template>"
"""File that Jinja names in a traceback for a template that was given as text."""

FORMATS: Final = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")
"""What is read."""

SIDE: Final = 1200
"""Longest side in the page [px]: sharp on half a page of A4."""

QUALITY: Final = 82
"""Of the JPEG in the page."""

_LABELS: Final = ("client", "order", "specimen", "standard", "operator")
_COLUMNS: Final = ("instrument", "serial number", "calibrated", "valid until")
_EXPIRED: Final = Markup('<b class="flag">{}, expired when used</b>')


@final
@dataclass(frozen=True, slots=True)
class Template:
    """A template of a log: the name of its file, and its text."""

    name: str
    text: str


class _Sandbox(ImmutableSandboxedEnvironment):
    """The sandbox of Jinja, in which nothing takes more than a moment."""

    intercepted_binops = frozenset({"**", "*"})

    def call_binop(self, context: object, operator: str, left: Any, right: Any) -> Any:
        """Return a power or product; of floating-point numbers, for those of integers no end.

        Text and lists are repeated as often as memory allows.
        """
        del context
        if operator == "**":
            return float(left) ** float(right)
        both = (left, right)
        if all(isinstance(one, int) for one in both) and max(map(abs, both)) > LARGEST_FACTOR:
            return float(left) * float(right)
        return left * right


def _ranges() -> Callable[..., range]:
    """Return ``range`` for one page: all that it gives is bounded, as are loops in loops."""
    left = MAX_RANGE

    def bounded(*ends: int) -> range:
        nonlocal left
        made = range(*ends)
        left -= len(made)
        if left < 0:
            raise OverflowError(f"ranges of more than {MAX_RANGE} items in one page")
        return made

    return bounded


def environment(template: Template | None = None) -> Environment:
    """Return the templates of the page, in a sandbox: no attribute that could do harm."""
    ours = PackageLoader("shakerproc.report.page")
    sandbox = _Sandbox(
        loader=ours
        if template is None
        else ChoiceLoader([DictLoader({_OWN: template.text}), ours]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    sandbox.globals["range"] = _ranges()
    return sandbox


def read_template(path: Path) -> Template:
    """Return a template that extends ours.

    Raises
    ------
    LogError
        If it cannot be read, is not written as a template, or extends no template of ours.
    """
    try:
        own = Template(path.name, path.read_text(encoding="utf-8"))
        templates = environment()
        parsed = templates.parse(own.text)
    except (TemplateError, OSError, UnicodeDecodeError) as error:
        raise LogError(_template_error(path.name, error)) from error
    first = next((one for one in parsed.body if not _is_blank(one)), None)
    extended = first.template if isinstance(first, nodes.Extends) else None
    if not isinstance(extended, nodes.Const) or extended.value != BASE:
        raise LogError(
            f'{path.name}: line 1: expected {{% extends "{BASE}" %}} at the top: a template '
            "changes blocks of the page, and leaves its head and its security policy"
        )
    blocks = templates.get_template(BASE).blocks
    for one in parsed.find_all(nodes.Block):
        if one.name not in blocks:
            raise LogError(
                f"{path.name}: line {one.lineno}: the page has no block {quoted(one.name)}, "
                f"but {', '.join(blocks)}"
            )
    return own


def _is_blank(node: nodes.Node) -> bool:
    """Return whether a node prints white space alone, as around a comment."""
    return isinstance(node, nodes.Output) and all(
        isinstance(part, nodes.TemplateData) and not part.data.strip() for part in node.nodes
    )


def rendered(
    templates: Environment, template: Template | None, content: Mapping[str, Any]
) -> str:
    """Return the page.

    Raises
    ------
    LogError
        If a template of the log does what it must not, or names what is not there.
    """
    if template is None:
        return templates.get_template(BASE).render(content)
    try:
        with limited_memory(MOST_MEMORY), deadline(MOST_SECONDS):
            return templates.get_template(_OWN).render(content)
    except Exception as error:  # a template may fail in any way
        raise LogError(_template_error(template.name, error)) from error


def _template_error(name: str, error: Exception) -> str:
    """Return the fault of a template and its line, in one line."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame.lineno for frame in frames if frame.filename == _FROM_TEXT]
    line = getattr(error, "lineno", None) or next(reversed(own), None)
    place = f"line {line}: " if line else ""
    said = " ".join(str(error).split()).rstrip(".") or type(error).__name__
    if isinstance(error, MemoryError):
        said = f"it takes more than {MOST_MEMORY / 1e9:g} GB of memory"
    if isinstance(error, DeadlineError):
        said = f"it takes more than {MOST_SECONDS:g} s"
    said = f"no template {said}" if isinstance(error, TemplateNotFound) else said
    return f"{name}: {place}{said}; correct the template, or take template out of report:"


class DeadlineError(Exception):
    """A block took more time than it may."""


@contextmanager
def deadline(seconds: float) -> Iterator[None]:
    """Raise within a block that takes longer than so many seconds [s].

    It is raised between two steps of the interpreter: what takes long in one step has to be
    bounded by itself.

    Raises
    ------
    DeadlineError
        Within the block.
    """
    thread, lock, over = threading.get_ident(), threading.Lock(), threading.Event()

    def end() -> None:
        with lock:
            if not over.is_set():
                _raise_in(thread, DeadlineError)

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        with lock:
            over.set()
        timer.cancel()


def _raise_in(thread: int, kind: type[Exception]) -> None:
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


def photo_uri(path: Path) -> str:
    """Return a photo as a data URI: turned upright, at most `SIDE` large, without metadata.

    Raises
    ------
    LogError
        If it is no picture that can be read, or too large a one.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        with warnings.catch_warnings(), _opened(path) as picture:
            picture.draft("RGB", (2 * SIDE, 2 * SIDE))
            upright = ImageOps.exif_transpose(picture)
            upright.thumbnail((SIDE, SIDE))
            flat = Image.new("RGB", upright.size, "white")
            layer = upright.convert("RGBA")
            flat.paste(layer, mask=layer.getchannel("A"))
    except (Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        most = (Image.MAX_IMAGE_PIXELS or 0) / 1e6
        raise LogError(
            f"{path}: the photo has more than {most:.0f} million pixels; save it smaller"
        ) from error
    except (UnidentifiedImageError, SyntaxError) as error:
        raise LogError(f"{path}: {_NO_PICTURE}") from error
    except (OSError, ValueError, EOFError) as error:
        raise LogError(f"{path}: {_NO_PICTURE} ({error})") from error
    content = io.BytesIO()
    flat.save(content, "JPEG", quality=QUALITY)
    return f"data:image/jpeg;base64,{base64.b64encode(content.getvalue()).decode()}"


def _opened(path: Path) -> "ImageFile":
    """Return a picture that is opened, if it does not unfold to more than Pillow deems safe."""
    from PIL import Image

    warnings.simplefilter("error", Image.DecompressionBombWarning)
    return Image.open(path, formats=FORMATS)


_NO_PICTURE: Final = f"no photo that can be read; save it as one of {', '.join(FORMATS)}"


@final
@dataclass(frozen=True, slots=True)
class HeaderView:
    """The head of a report; entries that the log lacks are left out.

    Attributes
    ----------
    lines : sequence of (str, str)
        Label and text.
    instruments : ReportTable, optional
        Instruments and sensors with their calibration, the last column until when it is valid.
    flag_names : sequence of str
        The same, one for each row, as flags of runs begin with it.
    photo : str
        The specimen as a data URI; empty where there is none.
    template : Template, optional
        The log's own template of the page.
    """

    lines: Sequence[tuple[str, str]]
    instruments: ReportTable | None = None
    flag_names: Sequence[str] = ()
    photo: str = ""
    template: Template | None = None


def header_view(log: TestLog) -> HeaderView | None:
    """Return the head of the report of a log; None where the log says nothing for it.

    Raises
    ------
    LogError
        If the photo cannot be read, or the template is none.
    """
    said = log.header
    if said is None:
        return None
    lines = [(name, text) for name in _LABELS if (text := getattr(said, name))]
    sensors = {
        one.serial: one
        for test in log.active
        for use in test.channels
        if (one := use.calibration) is not None
    }
    rows = [(one.name, one.serial, one.calibrated, one.valid_until) for one in said.instruments]
    rows += [
        (f"sensor, {one.sensitivity}", one.serial, one.calibrated, one.valid_until)
        for one in sensors.values()
    ]
    photo = "" if said.photo is None else photo_uri(said.photo)
    table = filled("Instruments", _COLUMNS, rows) if rows else None
    template = None if said.template is None else read_template(said.template)
    return HeaderView(
        lines,
        table,
        [*(i.sentence for i in said.instruments), *(s.sentence for s in sensors.values())],
        photo,
        template,
    )


def with_expired(view: HeaderView, runs: Sequence[RunSummary]) -> HeaderView:
    """Return the head of a report with a mark at each calibration that a run is flagged for."""
    if view.instruments is None:
        return view
    flagged = {flag.message for run in runs for flag in run.flags if flag.kind == EXPIRED}
    rows = [
        (*row[:-1], _EXPIRED.format(row[-1]))
        if any(message.startswith(f"{told}: ") for message in flagged)
        else row
        for row, told in zip(view.instruments.rows, view.flag_names, strict=True)
    ]
    return replace(view, instruments=replace(view.instruments, rows=rows))
