"""From two arrays to a response function, coherence and damping: no file, no log.

Yours come from anywhere; here a coupon at 250 Hz with Q = 25 is made up, with noise.
"""

import numpy as np

from shakerproc.spectra import coherence, cross_spectra, damping_of_response, h1

RATE, NATURAL, RATIO = 2560.0, 250.0, 0.02

rng = np.random.default_rng(1)
table = rng.standard_normal(round(60 * RATE))
share = np.fft.rfftfreq(table.size, 1.0 / RATE) / NATURAL
gain = (1.0 + 2j * RATIO * share) / (1.0 - share**2 + 2j * RATIO * share)
coupon = np.fft.irfft(np.fft.rfft(table) * gain) + 0.05 * rng.standard_normal(table.size)

spectra = cross_spectra(np.stack([table, coupon]), RATE, segment=2048, window="hann")
response = h1(spectra, [0], [1])[0]  # of row 1 over row 0, complex
linear = coherence(spectra, [0], [1])[0]
peak = spectra.frequency[np.argmax(np.abs(response))]
found = damping_of_response(spectra, [0], 1, peak, (20.0, 1000.0))

if __name__ == "__main__":
    print(f"{spectra.effective_averages:.0f} averages, bins {spectra.bin_width:.3g} Hz apart")
    print(f"natural frequency {found.frequency:.2f} Hz, damping ratio {found.ratio:.4f}")
    print(f"coherence at 100 Hz {linear[np.searchsorted(spectra.frequency, 100.0)]:.4f}")
