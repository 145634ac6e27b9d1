"""Files of the repository shown on a page of the manual (a hook): they stay one and the same.

``<!-- include: PATH LANGUAGE -->`` on a line of its own becomes a block with the file. A block
that is to be saved stands under ``<!-- file: NAME -->``, of which the reader sees the name.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
_FILE = re.compile(r"^<!-- file: (\S+) -->$", re.MULTILINE)
_INCLUDE = re.compile(r"^<!-- include: (\S+) (\w+) -->$", re.MULTILINE)


def on_page_markdown(
    markdown: str,
    page: "Page",  # noqa: ARG001 - what mkdocs hands over
    config: "MkDocsConfig",  # noqa: ARG001
    files: "Files",  # noqa: ARG001
) -> str:
    """Put files in place of what names them, and names over blocks that are files."""
    markdown = _FILE.sub(lambda found: f"`{found[1]}`:\n", markdown)
    return _INCLUDE.sub(lambda found: _block(found[1], found[2]), markdown)


def _block(path: str, language: str) -> str:
    text = (ROOT / path).read_text(encoding="utf-8")
    return f"```{language}\n{text.rstrip()}\n```"
