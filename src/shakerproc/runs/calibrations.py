"""Calibrations of a run: sensitivities of the sheet, and which have expired."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from typing import Final

from shakerproc.data import ChannelUse
from shakerproc.recordings.raw import RawGroup
from shakerproc.recordings.si import quantity_of
from shakerproc.runs.result import RunFlag
from shakerproc.testlog import Test
from shakerproc.units import numbered

EXPIRED: Final = "calibration"
"""Kind of the flags of what was used after its calibration had ended."""


def by_sheet(uses: Sequence[ChannelUse], group: RawGroup) -> tuple[ChannelUse, ...]:
    """Return channels with the sensitivities of the sheet, where the file holds volts.

    What a recorder has scaled already stays so, and what the log says itself counts.
    """
    units: dict[str | int, str] = {c.name: c.unit for c in group.channels}
    units |= {number: c.unit for number, c in enumerate(group.channels, 1)}
    return tuple(
        replace(use, sensitivity=use.calibration.sensitivity)
        if use.calibration is not None
        and use.sensitivity is None
        and quantity_of(numbered(use.unit)[1] if use.unit else units.get(use.key, ""))
        in {"", "V"}
        else use
        for use in uses
    )


def _calibrated(test: Test) -> list[ChannelUse]:
    every = [*test.channels, *(use for one in test.beside for use in one.channels)]
    return [use for use in every if use.calibration is not None and use.role != "ignore"]


def told_calibrations(test: Test) -> list[str]:
    """Return a sentence for each channel whose sensor is known."""
    return [
        f"Channel {use.name or use.key}: {use.calibration.told}."
        for use in _calibrated(test)
        if use.calibration is not None
    ]


def expired(test: Test, start: datetime | None) -> list[RunFlag]:
    """Return a flag for each sensor and instrument whose calibration ended before the test."""
    if start is None:
        return []
    day = start.date().isoformat()
    sensors = [(str(use.name or use.key), use.calibration) for use in _calibrated(test)]
    instruments = [("", one) for one in test.instruments]
    return [
        RunFlag(
            EXPIRED,
            channel,
            f"{one.told}: it had expired on {day}, the day of the test; calibrate it, or "
            "correct the day.",
        )
        for channel, one in (*sensors, *instruments)
        if one is not None and "" < one.valid_until < day
    ]
