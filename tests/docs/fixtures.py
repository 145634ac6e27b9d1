"""Recordings that pages of the manual speak of."""

import numpy as np
from nptdms import ChannelObject, TdmsWriter

RATE = 2560.0
VOLTS_PER_G = 0.1


def write_recordings(folder):
    """Write recordings/run_7.tdms: a coupon at 250 Hz with Q = 25, in volts, without units."""
    rng = np.random.default_rng(7)
    n = round(8 * RATE)
    time, frequency = np.arange(n) / RATE, np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    spectrum[(frequency < 20.0) | (frequency > 800.0)] = 0.0
    table = np.fft.irfft(spectrum, n)
    table *= np.clip(np.minimum(time - 0.5, 7.5 - time) / 0.1, 0.0, 1.0)
    table *= 2.0 / np.std(table)
    ratio, damping = frequency / 250.0, 0.02
    gain = (1.0 + 2j * damping * ratio) / (1.0 - ratio**2 + 2j * damping * ratio)
    coupon = np.fft.irfft(np.fft.rfft(table) * gain, n) + 0.01 * rng.standard_normal(n)
    properties = {"wf_increment": 1.0 / RATE, "wf_start_offset": 0.0}
    (folder / "recordings").mkdir()
    with TdmsWriter(folder / "recordings" / "run_7.tdms") as writer:
        writer.write_segment([
            ChannelObject("log", name, VOLTS_PER_G * samples, properties=properties)
            for name, samples in (("ai0", table), ("ai1", coupon))
        ])
