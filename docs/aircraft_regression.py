"""Laws in three places against what the modes of the aircraft leave, by regression.

python docs/aircraft_regression.py, without code of the program. Of the lines of the averaged
periods all is taken away that poles, their first-order shifts and residual terms explain, and
the same of the response of the modes to the force of each law. Even lines tell the factor of a
law, odd lines judge it.
"""

import sys
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).parents[2] / "shared/data/f16_level1/F16Data_FullMSine_Level1.csv"
RATE, PERIOD = 400.0, 8192
MODES = np.array([  # Hz, damping ratio, shapes of wing and payload [1/sqrt(kg)], by `modal`
    [3.47280, 0.015222, 0.033945, 0.032064],
    [3.96273, 0.022480, 0.029493, 0.027641],
    [5.18967, 0.008452, 0.031612, 0.027436],
    [6.61138, 0.006606, 0.021239, 0.024467],
    [7.32066, 0.004926, 0.076771, 0.073709],
    [9.16630, 0.007195, 0.066097, 0.057016],
])  # fmt: skip
LAWS = {
    "cubic": lambda x, _: x**3,
    "opening beyond 1 rms": lambda x, _: np.sign(x) * np.maximum(np.abs(x) - x.std(), 0.0),
    "quadratic": lambda x, _: x * np.abs(x),
    "dry friction": lambda _, v: np.tanh(v / (0.05 * v.std())),
    "quadratic damping": lambda _, v: v * np.abs(v),
}


def main() -> None:
    """Print a line for each law in each place, the best first."""
    rows = np.genfromtxt(SOURCE, delimiter=",", skip_header=1, usecols=(0, 3, 4)).T
    spectra = np.fft.rfft(rows.reshape(3, 9, PERIOD)[:, 1:].mean(axis=1))
    lines = np.fft.rfftfreq(PERIOD, 1.0 / RATE)
    omega = 2.0 * np.pi * lines
    band, kept = (lines >= 2.0) & (lines <= 15.0), (lines > 1.0) & (lines < 60.0)
    w, force = omega[band], spectra[0, band]
    natural, damping, shapes = 2.0 * np.pi * MODES[:, 0], MODES[:, 1], MODES[:, 2:]
    poles = natural * (1j * np.sqrt(1.0 - damping**2) - damping)
    columns = [
        force / (1j * w - pole) ** power for pole in (*poles, *poles.conj()) for power in (1, 2)
    ]
    columns += [force * (1j * w) ** power for power in (-2, -1, 0, 1, 2)]
    basis = np.linalg.qr(np.array([one / np.linalg.norm(one) for one in columns]).T)[0]
    left = [one - basis @ (basis.conj().T @ one) for one in spectra[1:, band]]
    share = np.linalg.norm(left) / np.linalg.norm(spectra[1:, band])
    moved = np.zeros_like(spectra[1:])
    moved[:, kept] = -spectra[1:, kept] / omega[kept] ** 2
    wing, payload = np.fft.irfft(moved, PERIOD)
    speeds = np.fft.irfft(1j * omega * moved, PERIOD)
    places = {
        "payload - wing": (payload - wing, speeds[1] - speeds[0], shapes[:, 1] - shapes[:, 0]),
        "wing": (wing, speeds[0], shapes[:, 0]),
        "payload": (payload, speeds[1], shapes[:, 1]),
    }
    receptance = 1.0 / (natural[:, None] ** 2 - w**2 + 2j * (damping * natural)[:, None] * w)
    even = np.tile(np.arange(w.size) % 2 == 0, 2)
    error, found = np.concatenate(left), []
    for place, (x, v, at) in places.items():
        for law, of in LAWS.items():
            push = np.fft.rfft(of(x, v))[band]
            said = [(shapes[:, k] * at) @ (-(w**2) * receptance) * push for k in (0, 1)]
            told = np.concatenate([one - basis @ (basis.conj().T @ one) for one in said])
            factor = (
                np.vdot(told[even], error[even]).real / np.vdot(told[even], told[even]).real
            )
            rest = error[~even] - factor * told[~even]
            found.append((
                np.linalg.norm(rest) / np.linalg.norm(error[~even]),
                place,
                law,
                -factor,
            ))
    sys.stdout.write(
        f"the linear part leaves {share:.3f}; wing moves by {wing.std():.3g} m rms, "
    )
    sys.stdout.write(f"payload against wing by {(payload - wing).std():.3g} m\n")
    for rest, place, law, factor in sorted(found):
        sys.stdout.write(f"{rest:.3f} of that left by {law} of {place}, factor {factor:.3g}\n")


if __name__ == "__main__":
    main()
