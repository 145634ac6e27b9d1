"""Conditions of a test, such as a voltage: as its log states or a channel measures them."""

from dataclasses import replace

from shakerproc.data import ChannelUse
from shakerproc.models import Conditions
from shakerproc.numerals import numeral
from shakerproc.runs.opening import open_path
from shakerproc.testlog import Expectation, Test


def stated(test: Test) -> Conditions:
    """Return the conditions of a test that its log states."""
    return Conditions(test.conditions, f"test {test.id}")


def conditions_of(test: Test) -> tuple[Conditions, tuple[str, ...]]:
    """Return all conditions of a test, and how much those vary that a channel measures.

    Of a channel the mean over the recording counts; what the log states counts before it.

    Raises
    ------
    ShakerprocError
        If the recording cannot be used.
    """
    values, told = dict(test.conditions), list[str]()
    for use in test.measured_conditions:
        name = use.name or str(use.key)
        if name not in values:
            mean, spread, unit = _mean(test, use)
            values[name] = f"{mean:.9g} {unit}"
            told.append(
                f"{name} {numeral(mean)} {unit} in the mean, varying by {numeral(spread, 2)} "
                f"{unit} rms"
            )
    return Conditions(values, f"test {test.id}"), tuple(told)


def _mean(test: Test, use: ChannelUse) -> tuple[float, float, str]:
    """Return mean and standard deviation of a channel over the recording, and their unit."""
    alone = replace(test, channels=(use,), beside=(), expect=Expectation())
    with open_path(test.require_recording(), alone) as recording:
        samples, unit = recording.samples()[0], recording.channels[0].unit
    return float(samples.mean()), float(samples.std()), unit
