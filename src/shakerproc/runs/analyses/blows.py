"""The blows of a hammer test: a table of those kept and rejected, their forces, advice."""

from collections.abc import Iterator
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import Recording
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult
from shakerproc.spectra.blows import LEAST_QUIET, Blow, Blows, rounded_up
from shakerproc.spectra.responses import excited

LEFT: Final = 0.05
"""Share of a response at the end of its block from which on leakage is told [-]: what is cut
off over what is there is about the error of a response function at its peaks, here 5 %."""

FALLEN: Final = 0.01
"""Share of the largest density of the force, 20 dB below it [-]."""

SOME: Final = 0.5
"""Share of the blows that a channel may miss and still be expected to respond [-]: one that is
silent more often than not sits where nothing moves, which is no fault of a cable."""

AROUND: Final = (2, 8)
"""Widths of a pulse that are drawn before and after the trigger [-]."""

MOST_DRAWN: Final = 40
"""Pulses that are drawn at most."""


@final
class BlowAnalysis(AbstractAnalysis):
    """Which blows were averaged, and which were not and why."""

    kind: ClassVar[str] = "blows"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the blows of a run; None where it was not struck."""
        del recording
        if result.over_time.blows is None:
            return None
        blows, rate = result.over_time.blows, result.recorded.sample_rate
        rows = tuple(_row(i, blow, rate) for i, blow in enumerate(blows.blows, 1))
        return Analysis(
            kind=self.kind,
            title=f"Blows: {len(blows.kept)} of {len(blows.blows)} averaged",
            columns={name: [row[name] for row in rows] for name in rows[0]},
            summary=rows,
            panels=(_pulses(blows),),
            sentences=(
                *_cut_text(blows, 100.0 * result.spectra.added_damping(1.0)),
                *_reach(result, blows),
            ),
            problems=tuple(_problems(blows)),
        )


def _row(number: int, blow: Blow, rate: float) -> dict[str, Cell]:
    known = bool(np.isfinite(blow.force))
    return {
        "blow": float(number),
        "time_s": blow.sample / rate,
        "force_n": blow.force if known else None,
        "width_ms": 1e3 * blow.width if known else None,
        "kept": blow.kept,
        "reason": blow.reason,
    }


def _cut_text(blows: Blows, added: float) -> list[str]:
    """Return how blows were cut; `added` is the damping of the window at 1 Hz [%]."""
    cut, rate = blows.setup.cut, blows.setup.cut.sample_rate
    sentences = [
        f"Trigger at {numeral(blows.setup.strikes.level, 4)} N; blocks of "
        f"{numeral(cut.length / rate, 4)} s, {numeral(cut.before / rate)} s of them before the "
        f"trigger, {numeral(rate / cut.length)} Hz from line to line."
    ]
    if cut.force_window is not None:
        sentences.append(
            f"The force is set to 0 from {numeral(cut.force_window / rate)} s after the "
            "trigger on."
        )
    if cut.decay_rate:
        sentences.append(
            f"The exponential window (time constant {numeral(1.0 / cut.decay_rate, 4)} s) "
            f"lowers and widens the peaks that are drawn. It adds {numeral(added, 4)} % times "
            "1 Hz/f to a damping ratio at f. Natural frequency and damping in the table of "
            "resonances are without it."
        )
    return sentences


def _reach(result: RunResult, blows: Blows) -> Iterator[str]:
    """Yield where the force has fallen by 20 dB, if it does within the band."""
    frequency, force = result.spectra.frequency, result.averages.psd[blows.setup.force]
    inside = excited(frequency, result.band)
    weak = frequency[inside & (force < FALLEN * force[inside].max())]
    if weak.size:
        yield (
            f"The force has fallen by 20 dB at {numeral(weak[0], 4)} Hz: above, functions and "
            "coherence suffer from noise first; a harder tip reaches further."
        )


def _problems(blows: Blows) -> list[str]:
    problems = []
    name = blows.setup.names[blows.setup.force]
    if blows.setup.strikes.sign < 0:
        problems.append(
            f"the blows of {name} are negative: the hammer is the wrong way round. All phases "
            "are off by 180°; give its sensitivity the other sign"
        )
    end_share, cut = blows.end_share, blows.setup.cut
    if end_share * np.exp(-cut.decay_rate * cut.length / cut.sample_rate) > LEFT:
        problems.append(
            f"{end_share:.0%} of a response is left at the end of the blocks (rms over its "
            "largest value): what is cut off falsifies the peaks. Take a longer block, or "
            "processing: {hammer: {exponential: 1 %}}, whose damping is taken away again"
        )
    problems += _silent(blows)
    if len(blows.kept) == 1:
        problems.append(
            "one blow is averaged, and one average has no coherence; strike three times or more"
        )
    if cut.quiet < LEAST_QUIET:
        problems.append(_unknown_noise(blows))
    return problems


def _unknown_noise(blows: Blows) -> str:
    """Return the message on unknown noise where too little lies before the blows."""
    cut = blows.setup.cut
    peaks = (
        ", and of the peaks of a single blow only the tallest is listed"
        if len(blows.kept) == 1
        else ""
    )
    return (
        f"{cut.quiet} samples in the quiet half of the pretrigger do not tell the noise. No "
        "channel is said not to respond, and the rest at the end of a block includes the "
        f"noise{peaks}. Give processing: {{hammer: {{pretrigger: "
        f"{rounded_up(1e3 * 2 * LEAST_QUIET / cut.sample_rate)} ms}}}} or more, or record more "
        "before the blow"
    )


def _silent(blows: Blows) -> Iterator[str]:
    """Yield which channel does not respond to some blows, although it does to most."""
    numbered = [(i, blow) for i, blow in enumerate(blows.blows, 1) if blow.kept]
    for name in blows.setup.names:
        missed = [str(i) for i, blow in numbered if name in blow.silent]
        if 0 < len(missed) <= SOME * len(numbered):
            yield (
                f"{name} does not respond to blow {', '.join(missed)} although it does to the "
                "others: look at its cable, or crop the blow away"
            )


def _pulses(blows: Blows) -> Panel:
    cut, name = blows.setup.cut, blows.setup.names[blows.setup.force]
    width = round(max(blow.width for blow in blows.kept) * cut.sample_rate)
    first = max(cut.before - AROUND[0] * width, 0)
    drawn = blows.pulses[:MOST_DRAWN, first : cut.before + AROUND[1] * width]
    after = first + np.arange(drawn.shape[1]) - cut.before
    time = np.asarray(1e3 / cut.sample_rate * after)
    return Panel(
        "blows_force",
        "Force of the blows that are averaged",
        f"{len(drawn)} of {len(blows.kept)} blows.",
        PanelScale("time after the trigger [ms]", logarithmic=False),
        PanelScale("force [N]", logarithmic=False),
        tuple(
            PanelLine("" if i else name, time, pulse, channel=name)
            for i, pulse in enumerate(drawn)
        ),
    )
