"""A draft of a test log: what recordings say, guesses, and marks for what they do not."""

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Final

from shakerproc.recordings.raw import Sampling
from shakerproc.workflows.draft_channels import (
    controls_of_seen,
    crop_of,
    entries,
    own_channels,
    quoted,
)
from shakerproc.workflows.recordings_seen import SeenRecording, natural

LOG: Final = """\
# The log sheet of a campaign: what was on the shaker, test by test. Begun by `shakerproc init`
# from the files; what it could not know is marked with ???, what it guessed with (guess).

testlog: 1
title: {title}
recordings: {folder}          # folder beside this file; nothing outside it is ever read

channels:                       # role: control sits on the table; or response, force, ignore
{channels}
processing:
  crop: {crop}
{times}
# Of each test: excitation, level and band, as in the second line here. With them the level is
# checked and only what was excited is judged. Mark one test of several levels hold_out: true.
#   - {{id: 1, recording: run_1.tdms, specimen: a, clearance: 0.05 mm, excitation: random,
#      level: 0.02 g^2/Hz, from: 20 Hz, to: 1000 Hz}}
tests:
{tests}"""


def log_text(
    folder: Path,
    recordings: Path,
    seen: Sequence[SeenRecording],
    said: Sampling,
    warn: Callable[[str], None],
) -> str:
    """Return the draft of a log for recordings, of which one that can be used comes first.

    Parameters
    ----------
    folder, recordings : Path
        Where the log goes, and the folder in it that holds the recordings.
    seen : sequence of SeenRecording
        The recordings.
    said : Sampling
        What is said of the times of the recordings.
    warn : callable
        Called with what may be wrong.
    """
    controls = controls_of_seen(seen[0])
    usual, crop = entries(seen[0]), crop_of(seen, controls)
    own = {one.path: own_channels(one, usual, controls, crop) for one in seen}
    first = seen[0].path.relative_to(recordings).as_posix()
    for path in (path for path, text in own.items() if text):
        name = path.relative_to(recordings).as_posix()
        warn(f"{name} has other channels than {first}; its line in tests: says which")
    below = recordings.resolve().relative_to(folder.resolve()).as_posix() or "."
    return LOG.format(
        title=quoted(folder.resolve().name),
        folder=quoted(below),
        channels="".join(f"  {key}: {use}   # {note}\n" for key, (use, note) in usual.items()),
        crop=crop,
        times=_times(said),
        tests=test_lines(own, recordings, ()),
    )


def _times(said: Sampling) -> str:
    """Return the lines of `processing` that say the same of the times."""
    rate = f"{said.rate:.10g} Hz" if said.rate else ""
    resample = f"{said.resample:.10g} Hz" if said.resample else ""
    given = {
        "sample_rate": f"{{value: {rate}, override: true}}" if said.override else rate,
        "time_unit": said.unit,
        "resample": resample,
        "starts": "ignore" if said.ignore_starts else "",
    }
    return "".join(f"  {key}: {value}\n" for key, value in given.items() if value)


def test_lines(own: Mapping[Path, str], recordings: Path, taken: Collection[str]) -> str:
    """Return a line for each recording, under the number in its name where that is unique.

    Parameters
    ----------
    own : mapping
        What each recording says of its channels, by its path.
    recordings : Path
        The folder that the log names.
    taken : collection of str
        Ids that other tests have already.
    """
    paths = sorted(own, key=lambda path: [natural(part) for part in path.parts])
    below = [path.relative_to(recordings).as_posix() for path in paths]
    numbers = [re.findall(r"\d+", path.removesuffix(Path(path).suffix)) for path in below]
    ids = [found[-1].lstrip("0") or "0" if found else "" for found in numbers]
    if len({*ids, *taken}) < len(ids) + len(taken) or "" in ids:
        begin = 1 + max((int(one) for one in taken if one.isdecimal()), default=0)
        ids = [str(i) for i in range(begin, begin + len(below))]
    wanted = "# ??? excitation, level, from, to"
    return "".join(
        f"  - {{id: {i}, recording: {quoted(name)}{own[path]}}}   {wanted}\n"
        for i, name, path in zip(ids, below, paths, strict=True)
    )
