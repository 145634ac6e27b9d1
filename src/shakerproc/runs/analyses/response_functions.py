"""The response functions of a run: table, summary, gains, phases and coherence."""

from collections.abc import Sequence
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.pairs import ChannelPair, force_remarks, functions_of
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import BoolArray, RunResult

DRAWN: Final = 8
"""Response functions that are drawn without being asked for: two rows of a page [-]."""


@final
class ResponseFunctionAnalysis(AbstractAnalysis):
    """Response functions between the channels that the log names, or against the force."""

    kind: ClassVar[str] = "response_functions"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the response functions of a run."""
        del recording  # its spectra are those of the result
        pairs, asked = functions_of(result), result.test.processing.response_functions
        remarks = force_remarks(result)
        if not pairs:
            title = "Response functions"
            return Analysis(self.kind, title, {}, (), (), remarks) if remarks else None
        frequency = result.spectra.frequency
        drawn = pairs if asked else pairs[:DRAWN]
        rest = "" if len(drawn) == len(pairs) else (
            f" (the first {DRAWN} of {len(pairs)} are drawn, all are in the table; "
            "response_functions in the log names others)"
        )  # fmt: skip
        return Analysis(
            kind=self.kind,
            title=f"Response functions{rest}",
            columns=_columns(frequency, pairs),
            summary=tuple(_row(frequency, pair) for pair in pairs),
            panels=(
                *(
                    panel
                    for i, pair in enumerate(drawn, 1)
                    for panel in _panels(frequency, pair, f"response_functions_{i}")
                ),
                _coherence(frequency, drawn),
            ),
            sentences=remarks,
        )


def _columns(
    frequency: FloatArray, pairs: Sequence[ChannelPair]
) -> dict[str, FloatArray | BoolArray]:
    columns: dict[str, FloatArray | BoolArray] = {"frequency_hz": frequency}
    for pair in pairs:
        name = pair.label.replace(" / ", "_over_")
        columns[f"h1_{name}_magnitude{pair.ending}"] = np.abs(pair.h1)
        columns[f"h1_{name}_low{pair.ending}"] = pair.low
        columns[f"h1_{name}_high{pair.ending}"] = pair.high
        columns[f"h1_{name}_phase_deg"] = np.degrees(np.angle(pair.h1))
        columns[f"h2_{name}_magnitude{pair.ending}"] = np.abs(pair.h2)
        columns[f"h2_{name}_phase_deg"] = np.degrees(np.angle(pair.h2))
        columns[f"hv_{name}_magnitude{pair.ending}"] = np.abs(pair.hv)
        columns[f"hv_{name}_phase_deg"] = np.degrees(np.angle(pair.hv))
        columns[f"coherence_{name}"] = pair.coherence
        columns[f"excited_{name}"] = pair.excited
    return columns


def _row(frequency: FloatArray, pair: ChannelPair) -> dict[str, Cell]:
    gain = np.where(pair.excited, np.abs(pair.h1), -np.inf)
    peak = int(np.argmax(gain))
    known = pair.coherence[pair.excited & np.isfinite(pair.coherence)]
    return {
        "function": pair.label,
        "name": pair.name,
        "unit": pair.unit,
        "largest": float(gain[peak]),
        "at_hz": float(frequency[peak]),
        "coherence_there": float(pair.coherence[peak]),
        "mean_coherence": float(known.mean()) if known.size else None,
    }


def _panels(frequency: FloatArray, pair: ChannelPair, name: str) -> list[Panel]:
    """Return gain, phase and locus."""
    shown = np.flatnonzero(pair.excited)
    part = slice(int(shown[0]), int(shown[-1]) + 1)
    h1 = np.where(pair.excited, pair.h1, np.nan + 0j)[part]
    x, title = frequency[part], f"{pair.label}, {pair.name}"
    limits = [
        PanelLine(label, x, np.where(pair.excited, values, np.nan)[part], look="paper")
        for label, values in (("", pair.low), ("", pair.high))
    ]
    by_frequency, unit = PanelScale("frequency [Hz]"), "-" if pair.unit == "1" else pair.unit
    phase, known = np.degrees(np.angle(h1)), np.isfinite(h1)
    phase = np.where(np.abs(np.diff(phase, prepend=phase[:1])) > 180.0, np.nan, phase)
    return [
        Panel(
            f"{name}_gain", f"|H1| of {title}", "Grey: its 95 % limits.", by_frequency,
            PanelScale(f"|H1| [{unit}]"),
            (*limits, PanelLine(pair.label, x, np.abs(h1), channel=pair.output)),
        ),
        Panel(
            f"{name}_phase", f"Phase of {title}", "Of H1; output after input.", by_frequency,
            PanelScale("phase [°]", logarithmic=False),
            (PanelLine(pair.label, x, phase, channel=pair.output),),
        ),
        Panel(
            f"{name}_nyquist", f"Nyquist plot of {title}", "A resonance is a circle.",
            PanelScale(f"real part [{unit}]", logarithmic=False),
            PanelScale(f"imaginary part [{unit}]", logarithmic=False),
            (PanelLine(pair.label, h1.real[known], h1.imag[known], channel=pair.output),),
            equal=True,
        ),
    ]  # fmt: skip


def _coherence(frequency: FloatArray, pairs: Sequence[ChannelPair]) -> Panel:
    shown = np.flatnonzero(np.any([pair.excited for pair in pairs], axis=0))
    part = slice(int(shown[0]), int(shown[-1]) + 1)
    return Panel(
        "response_functions_coherence", "Coherence of the response functions",
        "1: all of the output is a linear answer to the input, without noise. Of several "
        "forces: partial coherence, without what the others cause.",
        PanelScale("frequency [Hz]"),
        PanelScale("coherence [-]", logarithmic=False, ends=(0.0, 1.02)),
        tuple(
            PanelLine(
                pair.label,
                frequency[part],
                np.where(pair.excited, pair.coherence, np.nan)[part],
                channel=pair.output,
            )
            for pair in pairs
        ),
    )  # fmt: skip
