"""The report on paper: printed by whatever browser is installed, without a network."""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from shakerproc import files
from shakerproc.errors import PrintingError

BROWSER_VARIABLE: Final = "SHAKERPROC_BROWSER"
"""Environment variable that names a browser, before all others."""

NAMES: Final = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome",
    "microsoft-edge", "microsoft-edge-stable", "msedge", "brave-browser",
)  # fmt: skip
"""Programs that print, as they are called on the search path."""

ON_WINDOWS: Final = (
    "Google/Chrome/Application/chrome.exe",
    "Microsoft/Edge/Application/msedge.exe",
    "Chromium/Application/chrome.exe",
)
ON_A_MAC: Final = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)

LONGEST: Final = 300.0
"""Time that a browser may take [s]."""


def find_browser() -> str | None:
    """Return the path of a browser that can print, or None."""
    named = os.environ.get(BROWSER_VARIABLE)
    if named:
        return shutil.which(named)
    found = (shutil.which(name) for name in NAMES)
    return next(filter(None, (*found, *_usual_places())), None)


def _usual_places() -> Iterator[str]:
    """Yield browsers that stand where installers put them, off the search path."""
    if os.name == "nt":
        for variable in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA"):
            root = os.environ.get(variable)
            yield from (
                str(path) for end in ON_WINDOWS if root and (path := Path(root) / end).is_file()
            )
    elif sys.platform == "darwin":
        yield from (path for path in ON_A_MAC if Path(path).is_file())


def print_report(page: Path, target: Path) -> Path:
    """Print a report to PDF, whole or not at all, and return the file.

    Raises
    ------
    PrintingError
        If no browser is installed, or it does not print.
    """
    browser = find_browser()
    if browser is None:
        named = os.environ.get(BROWSER_VARIABLE)
        lack = f"{BROWSER_VARIABLE} names {named!r}, which is not there" if named else (
            "printing takes Chromium, Chrome or Edge, and none is found"
        )  # fmt: skip
        raise PrintingError(
            f"no PDF: {lack}. Install one, or open {page} in any browser and print it there."
        )
    with files.atomic_path(target) as temporary, tempfile.TemporaryDirectory() as profile:
        said = _run(browser, page, temporary, profile)
        if not temporary.is_file() or temporary.stat().st_size == 0:
            temporary.touch()
            raise PrintingError(
                f"no PDF of {page}: {browser} printed nothing{said}. Open the page in a "
                f"browser and print it there, or name another in {BROWSER_VARIABLE}."
            )
    return target


def _run(browser: str, page: Path, target: Path, profile: str) -> str:
    """Let a browser print; return the last thing it said, for an error message.

    Raises
    ------
    PrintingError
        If it takes too long or cannot be started.
    """
    command = [
        browser, "--headless", "--disable-gpu", "--no-first-run", "--no-default-browser-check",
        "--disable-extensions", "--disable-background-networking", "--no-pdf-header-footer",
        "--generate-pdf-document-outline",
        f"--user-data-dir={profile}", f"--print-to-pdf={target.resolve()}",
        page.resolve().as_uri(),
    ]  # fmt: skip
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        command.insert(1, "--no-sandbox")  # Chromium refuses to start as root with one
    try:
        done = subprocess.run(  # noqa: S603 - a browser and a page of ours
            command, capture_output=True, timeout=LONGEST, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PrintingError(f"no PDF of {page}: {browser}: {error}") from error
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return f" ({files.printable(lines[-1])[:200]})" if lines and done.returncode else ""
