"""The page of the Python functions, made from their docstrings (a hook of the manual)."""

import inspect
import re
from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Any, get_args

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

FUNCTIONS, RESULTS = "<!-- all functions -->", "<!-- all results -->"
_SECTION = re.compile(r"^(\w[\w ]*)\n-+\n", re.MULTILINE)
_ITEM = re.compile(r"^(\S[^\n]*)\n?((?:[ \t]+[^\n]*\n?|\n)*)", re.MULTILINE)


def on_page_markdown(
    markdown: str,
    page: "Page",  # noqa: ARG001 - what mkdocs hands over
    config: "MkDocsConfig",  # noqa: ARG001
    files: "Files",  # noqa: ARG001
) -> str:
    """Put the functions and their results where the page wants them."""
    if FUNCTIONS not in markdown:
        return markdown
    return markdown.replace(FUNCTIONS, functions()).replace(RESULTS, results())


def functions() -> str:
    """Return a section for each function of the public API."""
    import shakerproc

    return "\n\n".join(_function(name, getattr(shakerproc, name)) for name in shakerproc.API)


def results() -> str:
    """Return a section for each result, and for the options that functions share."""
    from shakerproc.workflows.processing_options import Options

    return "\n\n".join(_class(made) for made in (*result_classes(), Options))


def result_classes() -> list[type]:
    """Return what the functions return that is made for a notebook, each once."""
    import shakerproc
    from shakerproc.workflows.shown import Shown

    found: dict[str, type] = {}
    for name in shakerproc.API:
        made = inspect.signature(getattr(shakerproc, name), eval_str=True).return_annotation
        for one in get_args(made) or (made,):  # a function may return one of two
            if issubclass(one, Shown):
                found[one.__name__] = one
    return list(found.values())


def _function(name: str, function: Any) -> str:
    return f"### {name}\n\n```python\n{_signature(name, function)}\n```\n\n{told(function)}"


def _signature(name: str, function: Any) -> str:
    """Return how a function is called: an argument on each line."""
    shown = [
        str(one.replace(annotation=inspect.Parameter.empty))
        for one in inspect.signature(function).parameters.values()
    ]
    keywords = [
        one.kind is inspect.Parameter.KEYWORD_ONLY
        for one in inspect.signature(function).parameters.values()
    ]
    if any(keywords):
        shown.insert(keywords.index(True), "*")
    return f"{name}({', '.join(shown)})"


def _class(made: type) -> str:
    parts = [f"### {made.__name__}", told(made)]
    for name, member in vars(made).items():
        if name.startswith("_") or name == "as_json" or not is_dataclass(made):
            continue
        if isinstance(member, property):
            parts.append(f"**`.{name}`** {told(member.fget)}")
        elif inspect.isfunction(member):
            call = _signature(name, member).replace("(self, ", "(").replace("(self)", "()")
            parts.append(f"**`.{call}`** {told(member)}")
    return "\n\n".join(parts)


def told(of: Any) -> str:
    """Return a docstring (numpydoc) as Markdown."""
    first, *sections = _SECTION.split(inspect.getdoc(of) or "")
    lines = [_plain(first.strip())]
    for heading, body in zip(sections[::2], sections[1::2], strict=True):
        lines.append(f"*{heading}*")
        lines.append("\n".join(_item(*found) for found in _ITEM.findall(body)))
    return "\n\n".join(lines)


def _item(head: str, body: str) -> str:
    name, _, kind = head.partition(" : ")
    text = _plain(" ".join(body.split()))
    return f"- `{name}`{f' ({kind})' if kind else ''}: {text}"


def _plain(text: str) -> str:
    """Return text without the marks of reStructuredText."""
    return re.sub(r"(?<!`)`([^`\n]+)`(?!`)", r"`\1`", text).replace("``", "`")
