"""Drawn campaigns in a folder, so that a second run does not integrate them again."""

import json
import os
import zlib
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from blind.campaign import Campaign, TestRun
from blind.excitations import Drive
from blind.structures import Joint, Structure

VERSION = 4
"""Raise it where a draw changes."""
ROWS = ("control", "response", "clean")


def place(seed: int, text: str) -> Path | None:
    """Return the file of a campaign in `BLIND_CACHE`, or None where that is not set."""
    folder = os.environ.get("BLIND_CACHE")
    if not folder:
        return None
    return Path(folder) / f"{zlib.crc32(text.encode()):08x}_{seed}_{VERSION}.npz"


def store(campaign: Campaign) -> None:
    """Keep a campaign, if a folder is named."""
    path = place(campaign.seed, campaign.kind)
    if path is None:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = {
        f"{row}_{i}": getattr(test, row)
        for i, test in enumerate(campaign.tests)
        for row in ROWS
    }
    words = {
        "kind": campaign.kind,
        "structure": asdict(campaign.structure),
        "nominal": asdict(campaign.nominal),
        "drives": [asdict(test.drive) for test in campaign.tests],
        "truth": campaign.truth,
        "noise_floor": campaign.noise_floor,
        "details": campaign.details,
    }
    partial = path.with_suffix(f".{os.getpid()}.npz")
    np.savez(partial, words=np.array(json.dumps(words)), **arrays)
    partial.replace(path)


def load(seed: int, text: str) -> Campaign | None:
    """Return a stored campaign, or None."""
    path = place(seed, text)
    if path is None or not path.exists():
        return None
    with np.load(path) as stored:
        words = json.loads(str(stored["words"]))
        if words["kind"] != text:
            return None
        tests = tuple(
            TestRun(i + 1, Drive(**drive | {"seed": tuple(drive["seed"])}), i == 3,
                    *(stored[f"{row}_{i}"] for row in ROWS))
            for i, drive in enumerate(words["drives"])
        )  # fmt: skip
    return Campaign(
        seed, text, _structure(words["structure"]), _structure(words["nominal"]), tests,
        words["truth"], words["noise_floor"], words["details"],
    )  # fmt: skip


def _structure(words: dict[str, Any]) -> Structure:
    joints = tuple(Joint(**joint) for joint in words["joints"])
    return Structure(tuple(words["masses"]), joints, words["force_on"], words["measures"])
