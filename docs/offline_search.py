"""A search that works in pages opened from a folder, without a server (a hook)."""

import json
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig


def on_post_build(config: "MkDocsConfig") -> None:
    """Put our search in place of the theme's, with the index as a script."""
    folder = Path(config.site_dir) / "search"
    index = json.loads((folder / "search_index.json").read_text(encoding="utf-8"))
    text = json.dumps(index["docs"], ensure_ascii=False)
    (folder / "search_index.js").write_text(f"var manual_pages = {text};\n", encoding="utf-8")
    (folder / "search_index.json").unlink()
    (folder / "worker.js").unlink()
    shutil.copyfile(Path(__file__).with_name("search.js"), folder / "main.js")
