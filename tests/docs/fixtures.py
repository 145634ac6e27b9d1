"""Recordings that pages of the manual speak of."""

import numpy as np
from nptdms import ChannelObject, TdmsWriter
from tests.struck import RATE as STRUCK_RATE
from tests.struck import struck

RATE = 2560.0
VOLTS_PER_G = 0.1


def write_recordings(folder):
    """Write the recordings of the how-to pages."""
    (folder / "recordings").mkdir()
    write_run_7(folder / "recordings" / "run_7.tdms")
    write_hammer(folder / "recordings" / "plate.csv")


def write_hammer(path):
    """Write a plate struck nine times: a rebound, an overload, a blow that nothing answers."""
    blows = [(1.0 + 2.0 * k, 120.0 + 10.0 * k) for k in range(9)]
    rows = struck([*blows, (7.07, 50.0)], 19.0, noise=(0.05, 0.01))
    off = slice(round(10.9 * STRUCK_RATE), round(12.9 * STRUCK_RATE))
    rows[1:, off] = 0.01 * np.random.default_rng(4).standard_normal(rows[1:, off].shape)
    rows[0] = np.minimum(rows[0], 185.0)
    time = np.arange(rows.shape[1]) / STRUCK_RATE
    np.savetxt(
        path,
        np.column_stack([time, *rows]),
        fmt="%.7g",
        delimiter=",",
        header="time [s],hammer [N],plate [m/s^2],rim [m/s^2]",
        comments="",
    )


def write_run_7(path):
    """Write a coupon at 250 Hz with Q = 25, in volts, without units."""
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
    with TdmsWriter(path) as writer:
        writer.write_segment([
            ChannelObject("log", name, VOLTS_PER_G * samples, properties=properties)
            for name, samples in (("ai0", table), ("ai1", coupon))
        ])
