"""Channels against each other: controls that differ, polarity, gain where none is possible."""

from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings.health.base import (
    AbstractHealthCheck,
    Flag,
    Pieces,
    control_rows,
    listed,
)

LOOK: Final = 2.0
"""Length of the pieces that are transformed [s]; one is taken from a block."""

FEWEST: Final = 4
"""Pieces at least, which are shorter in a short test: it is judged by its periods.

Two channels that have nothing in common pass `COHERENT` in a bin by 1 chance in 8000.
"""

MOST: Final = 64
"""Pieces at most."""

DIFFER: Final = 0.1
"""How far the rms of controls may part, relative."""

COHERENT: Final = 0.95
FEWEST_BINS: Final = 12
PERIODS: Final = 2
"""Periods of a frequency that a piece holds at least."""
OCTAVES: Final = 1.0
PAST: Final = -1.0
"""Logarithmic slope of the gain below which a motion is opposed since it is past a resonance.

Past a resonance the gain falls with a slope of -2 at least, before it does not fall.
"""

OPPOSED: Final = 30.0
"""How near 180 degrees the phase must be in the lower half of the band [degrees]."""

FLAT: Final = 0.5
"""Logarithmic slope of the gain up to which a response still follows its base.

Below a resonance the gain is 1 / (1 - r^2): its slope is 0.5 at r = 0.45, where the gain is
1.25. Of a system above its resonance it is -1 at least.
"""

FAR: Final = 2.0
"""Gain, or its inverse, from which on no such response follows its base with the right units.

Where the slope is at most `FLAT` a resonance adds 25 %; sensors of a table differ by less.
"""

REASONS: Final = (
    (9.80665, "g taken for m/s^2"),
    (10.0, "a decimal point of the sensitivity"),
    (100.0, "a decimal point of the sensitivity"),
    (1000.0, "mV taken for V"),
)
"""Factors that mistakes of units make, and which."""

MATCHES: Final = 1.25
"""Factor within which a gain is that of such a mistake: what a resonance may add."""


@final
class CrossChannel(AbstractHealthCheck):
    """Watches power and phase of the channels in pieces of two seconds, or of a quarter."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._controls = control_rows(recording)
        rate, n = recording.sample_rate, recording.n_samples
        doublings = np.clip(np.rint(np.log2(LOOK) + np.log2(rate)), 3, 62)
        self._size = min(1 << int(doublings), n // FEWEST) if n > 16 else 0
        every = max(1, n // (MOST * max(self._size, 1)))
        whole = range(0, n - self._size + 1, every * self._size) if self._size else ()
        self._window = np.hanning(self._size)
        count, bins = len(recording.channels), self._size // 2 + 1
        self._power = np.zeros((count, bins))
        self._cross = np.zeros((count, bins), dtype=np.complex128)
        self._whole = Pieces(whole, self._size)
        self._pieces = 0
        self._squares = np.zeros(count)
        self._sums = np.zeros(count)

    def add(self, first: int, block: FloatArray) -> None:
        self._squares += np.einsum("ij,ij->i", block, block)
        self._sums += block.sum(axis=1)
        for piece in self._whole.of(first, block):
            self._transform(piece)

    def _transform(self, piece: FloatArray) -> None:
        level = piece - piece.mean(axis=1, keepdims=True)
        spectrum = np.fft.rfft(level * self._window, axis=1)
        self._power += spectrum.real**2 + spectrum.imag**2
        if self._controls:
            self._cross += spectrum * np.conj(spectrum[self._controls[0]])
        self._pieces += 1

    def flags(self) -> list[Flag]:
        return [*self._differing(), *self._opposed(), *self._out_of_proportion()]

    def _flag(self, kind: str, channel: str, message: str) -> Flag:
        return Flag(kind, channel, message, 0.0, self._recording.duration)

    def _differing(self) -> list[Flag]:
        """Return a flag if the controls do not move alike."""
        if len(self._controls) < 2:
            return []
        n = self._recording.n_samples
        mean = self._sums / n
        level = np.sqrt(np.maximum(self._squares / n - mean**2, 0.0))[self._controls]
        if level.max() <= (1.0 + DIFFER) * level.min() or not self._mostly_one_motion():
            return []
        channels = self._recording.channels
        names = listed([channels[i].name for i in self._controls])
        values = listed([numeral(value, 4) for value in level])
        return [
            self._flag(
                "controls differ",
                channels[self._controls[int(np.argmin(level))]].name,
                f"The rms of {names} are {values} {channels[self._controls[0]].unit}, more "
                f"than {100 * DIFFER:.0f} % apart. Check the sensitivities, or where they sit.",
            )
        ]

    def _mostly_one_motion(self) -> bool:
        """Return whether the controls measure mostly one motion, not their noise."""
        first, *others = self._controls
        power = self._power[first].sum() * self._power[others].sum(axis=1)
        common = np.abs(self._cross[others]).sum(axis=1) ** 2
        return bool(self._pieces > 1 and np.all(common > 0.5 * power))

    def _opposed(self) -> list[Flag]:
        """Return the channels that move against the first control where they cannot."""
        flags = []
        for row, channel in enumerate(self._recording.channels):
            if not self._controls or row == self._controls[0]:
                continue
            if channel.unit == self._recording.channels[self._controls[0]].unit and (
                self._is_opposed(row)
            ):
                control = self._recording.channels[self._controls[0]].name
                flags.append(
                    self._flag(
                        "polarity",
                        channel.name,
                        f"Moves against {control} at the lowest frequencies, where both should "
                        "move together. Turn the sensor round, or its sign.",
                    )
                )
        return flags

    def _out_of_proportion(self) -> list[Flag]:
        """Return the channels that follow the first control with a gain far from 1.

        At the lowest frequencies a structure moves as one with the table. Where a force is
        measured the control may be a point of a free structure, which turns as well.
        """
        channels = self._recording.channels
        if not self._controls or any(channel.unit == "N" for channel in channels):
            return []
        control = channels[self._controls[0]]
        others = [
            row for row, channel in enumerate(channels)
            if row != self._controls[0] and channel.unit == control.unit
        ]  # fmt: skip
        gains = {row: gain for row in others if (gain := self._following(row)) is not None}
        far = {row: gain for row, gain in gains.items() if not 1.0 / FAR < gain < FAR}
        if len(far) > 1 and len(far) == len(others) and (
            max(far.values()) < MATCHES * min(far.values())
        ):  # fmt: skip
            inverse = 1.0 / float(np.median(list(far.values())))
            return [self._disproportion(control.name, "every other channel", inverse)]
        return [
            self._disproportion(channels[row].name, control.name, gain)
            for row, gain in far.items()
        ]

    def _disproportion(self, name: str, reference: str, gain: float) -> Flag:
        size = max(gain, 1.0 / gain)
        likely = [why for factor, why in REASONS if 1.0 / MATCHES < size / factor < MATCHES]
        reason = f" Likely: {' or '.join(dict.fromkeys(likely))}." if likely else ""
        return self._flag(
            "gain",
            name,
            f"Follows {reference} at the lowest frequencies with a gain of {numeral(gain)}, "
            f"where it must be near 1.{reason} Check sensitivity and unit; a sensor across "
            "the drive needs no change.",
        )

    def _following(self, row: int) -> float | None:
        """Return the gain in the lowest octave, over a dozen bins at least [-]; else None."""
        reference, good = self._power[self._controls[0]], self._good(row)
        if good is None:
            return None
        low = good[: max(FEWEST_BINS, int(np.count_nonzero(good <= 2.0 * good[0])))]
        cross = self._cross[row][low]
        phase = np.abs(np.degrees(np.angle(cross)))
        if not (np.all(phase < OPPOSED) or np.all(phase > 180.0 - OPPOSED)):
            return None
        gain = np.abs(cross) / reference[low]
        slope = np.polyfit(np.log(low), np.log(gain), 1)[0]
        return float(np.median(gain)) if abs(slope) <= FLAT else None

    def _good(self, row: int) -> NDArray[np.intp] | None:
        """Return the bins in which a channel moves with the first control, if enough do."""
        reference = self._power[self._controls[0]]
        if self._pieces < FEWEST:
            return None
        product = reference * self._power[row]
        strong = reference > 1e-6 * reference.max()
        coherence = np.zeros_like(product)
        np.divide(np.abs(self._cross[row]) ** 2, product, out=coherence, where=product > 0)
        good = np.flatnonzero(strong & (coherence > COHERENT))
        good = good[good >= PERIODS]
        if good.size < FEWEST_BINS or good[-1] < 2.0**OCTAVES * good[0]:
            return None
        return good

    def _is_opposed(self, row: int) -> bool:
        reference, good = self._power[self._controls[0]], self._good(row)
        if good is None:
            return False
        low = good[good <= np.sqrt(float(good[0]) * float(good[-1]))]
        phase = np.abs(np.degrees(np.angle(self._cross[row][low])))
        if low.size < FEWEST_BINS // 3 or not np.all(phase > 180.0 - OPPOSED):
            return False
        gain = np.log(np.abs(self._cross[row][low]) / reference[low])
        slope = np.polyfit(np.log(low), gain, 1)[0]
        return bool(slope > PAST)
