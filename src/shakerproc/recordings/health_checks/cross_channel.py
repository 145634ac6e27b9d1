"""Channels against each other: controls that differ, polarity."""

from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health_checks.base import (
    AbstractHealthCheck,
    Flag,
    control_rows,
    listed,
)
from shakerproc.recordings.health_checks.pieces import Pieces

LOOK: Final = 2.0
"""Length of the pieces that are transformed [s]; one is taken from a block."""

MOST: Final = 64
"""Pieces at most."""

DIFFER: Final = 0.1
"""How far the rms of controls may part, relative."""

COHERENT: Final = 0.95
FEWEST_BINS: Final = 12
OCTAVES: Final = 1.0
PAST: Final = -1.0
"""Logarithmic slope of the gain below which a motion is opposed since it is past a resonance.

Past a resonance the gain falls with a slope of -2 at least, before it does not fall.
"""

OPPOSED: Final = 30.0
"""How near 180 degrees the phase must be in the lower half of the band [degrees]."""


@final
class CrossChannel(AbstractHealthCheck):
    """Watches power and phase of the channels in pieces of two seconds."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._controls = control_rows(recording)
        rate, n = recording.sample_rate, recording.n_samples
        doublings = np.clip(np.rint(np.log2(LOOK) + np.log2(rate)), 3, 62)
        self._size = min(1 << int(doublings), n) if n > 16 else 0
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
        return [*self._differing(), *self._opposed()]

    def _flag(self, kind: str, channel: str, message: str) -> Flag:
        return Flag(kind, channel, message, 0.0, self._recording.duration)

    def _differing(self) -> list[Flag]:
        """Return a flag if the controls do not move alike."""
        if len(self._controls) < 2:
            return []
        n = self._recording.n_samples
        mean = self._sums / n
        level = np.sqrt(np.maximum(self._squares / n - mean**2, 0.0))[self._controls]
        if level.max() <= (1.0 + DIFFER) * level.min() or not self._move_alike():
            return []
        channels = self._recording.channels
        names = listed([channels[i].name for i in self._controls])
        values = listed([f"{value:.4g}" for value in level])
        return [
            self._flag(
                "controls differ",
                channels[self._controls[int(np.argmin(level))]].name,
                f"The rms of {names} are {values} {channels[self._controls[0]].unit}, more "
                f"than {100 * DIFFER:.0f} % apart. Check the sensitivities, or where they sit.",
            )
        ]

    def _move_alike(self) -> bool:
        """Return whether most of what the controls measure is one motion, not their noise."""
        first, *others = self._controls
        power = self._power[first].sum() * self._power[others].sum(axis=1)
        common = np.abs(self._cross[others]).sum(axis=1) ** 2
        return bool(self._pieces > 1 and np.all(common > 0.5 * power))

    def _opposed(self) -> list[Flag]:
        """Return the channels that move against the first control where they cannot."""
        found = []
        for row, channel in enumerate(self._recording.channels):
            if not self._controls or row == self._controls[0]:
                continue
            if channel.unit == self._recording.channels[self._controls[0]].unit and (
                self._is_opposed(row)
            ):
                control = self._recording.channels[self._controls[0]].name
                found.append(
                    self._flag(
                        "polarity",
                        channel.name,
                        f"Moves against {control} at the lowest frequencies, where both should "
                        "move together. Turn the sensor round, or its sign.",
                    )
                )
        return found

    def _is_opposed(self, row: int) -> bool:
        reference = self._power[self._controls[0]]
        if self._pieces < 4:
            return False
        product = reference * self._power[row]
        strong = reference > 1e-6 * reference.max()
        coherence = np.zeros_like(product)
        np.divide(np.abs(self._cross[row]) ** 2, product, out=coherence, where=product > 0)
        good = np.flatnonzero(strong & (coherence > COHERENT))
        good = good[good > 1]
        if good.size < FEWEST_BINS or good[-1] < 2.0**OCTAVES * good[0]:
            return False
        low = good[good <= np.sqrt(float(good[0]) * float(good[-1]))]
        phase = np.abs(np.degrees(np.angle(self._cross[row][low])))
        if low.size < FEWEST_BINS // 3 or not np.all(phase > 180.0 - OPPOSED):
            return False
        gain = np.log(np.abs(self._cross[row][low]) / reference[low])
        slope = np.polyfit(np.log(low), gain, 1)[0]
        return bool(slope > PAST)
