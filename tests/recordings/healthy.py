"""``python -m tests.recordings.healthy 500``: no flag on healthy runs; each dead channel found.

Runs are simulated: linear and nonlinear specimens, driven at random, by a sine or a sweep,
in a burst, or left to decay, with one to eight channels, noise, and converters of 16 and 24 bit
whose range is wider than the signal. Then a channel of driven runs is made dead in five
ways, and one of random runs wrong in three.
"""

import sys
from dataclasses import replace

import numpy as np
from scipy import signal

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.recordings import health, unusable
from shakerproc.simulation import simulate

KINDS = ("random", "sine sweep", "sine", "burst", "decay")
NONLINEAR = ("", "gap", "cubic_stiffness", "coulomb_friction", "jenkins", "quadratic_damping")
LEAST_FOUND = 0.95  # of the channels that are dead in one way; each that is missed is printed
OPEN = 0.005 * 9.80665  # m/s^2 rms: 5 mg, what an open input shows


def specimen(rng):
    """Two masses on springs, one of them nonlinear perhaps; frequencies 40 to 300 Hz."""
    mass, omega = 0.1, 2.0 * np.pi * np.exp(rng.uniform(np.log(40.0), np.log(300.0)))
    stiffness, zeta = mass * omega**2, np.exp(rng.uniform(np.log(0.003), np.log(0.05)))
    elements = [
        Element(EFFECTS["spring"](stiffness), ("base", "one")),
        Element(EFFECTS["damper"](2.0 * zeta * mass * omega), ("base", "one")),
        Element(EFFECTS["spring"](3.0 * stiffness), ("one", "two")),
        Element(EFFECTS["damper"](zeta * mass * omega), ("one", "two")),
    ]
    motion = 30.0 / omega**2  # of the order of the displacement under some g
    numbers = {
        "gap": (0.5 * stiffness, 0.3 * motion),
        "cubic_stiffness": (0.2 * stiffness / motion**2,),
        "coulomb_friction": (0.1 * stiffness * motion,),
        "jenkins": (0.5 * stiffness, 0.2 * stiffness * motion),
        "quadratic_damping": (0.05 * stiffness / (omega * motion) ** 2 * motion,),
    }
    kind = NONLINEAR[rng.integers(len(NONLINEAR))]
    if kind:
        elements.append(Element(EFFECTS[kind](*numbers[kind]), ("base", "one")))
    sensors = {name: Sensor(name, "acceleration") for name in ("one", "two")}
    return Model(
        "specimen",
        {"one": mass, "two": 0.05},
        tuple(elements),
        Excitation("base acceleration"),
        sensors,
    )


def drive(kind, rng, n, rate):
    """Acceleration of the table [m/s^2]."""
    t = np.arange(n) / rate
    size = np.exp(rng.uniform(np.log(3.0), np.log(60.0)))
    if kind in {"random", "burst"}:
        spectrum = np.fft.rfft(rng.standard_normal(n))
        frequency = np.fft.rfftfreq(n, 1.0 / rate)
        spectrum[(frequency < 5.0) | (frequency > 0.35 * rate)] = 0.0
        wave = size * np.fft.irfft(spectrum, n)
        ending = np.clip((0.6 * t[-1] - t) / 0.1, 0.0, 1.0) ** 2
        return wave * ending if kind == "burst" else wave
    if kind == "sine sweep":
        low, high = sorted(np.exp(rng.uniform(np.log(8.0), np.log(500.0), 2)))
        growth = np.log(max(high, 4.0 * low) / low) / t[-1]
        return size * np.sin(2.0 * np.pi * low * np.expm1(growth * t) / growth)
    if kind == "sine":
        return size * np.sin(2.0 * np.pi * rng.uniform(15.0, 300.0) * t)
    return 10.0 * size * np.sin(np.pi * t / 0.004) * (t < 0.004)


def converted(samples, rng):
    """What a converter of 16 or 24 bit makes of a channel, its range wider than the signal."""
    reach = float(np.max(np.abs(samples))) * np.exp(rng.uniform(np.log(1.2), np.log(8.0)))
    step = 10.0 ** np.ceil(np.log10(reach)) / 2.0 ** (rng.choice([16, 24]) - 1)
    return np.round(samples / step) * step


def healthy_run(seed):
    """A recording with nothing wrong, and its kind of excitation."""
    rng = np.random.default_rng([12, seed])
    kind = KINDS[seed % len(KINDS)]
    rate, n = float(rng.choice([2048.0, 5688.9, 10240.0])), int(rng.integers(16_000, 50_000))
    lead = int(0.02 * rate) if kind == "decay" else 0
    table = drive(kind, rng, n + lead, rate)
    moved = simulate(specimen(rng), table, rate, growth=False).outputs
    count = int(rng.integers(1, 9))
    controls = 0 if count == 1 else int(rng.integers(0 if count > 2 else 1, min(3, count)))
    rows, channels = [], []
    for i in range(count):
        share = rng.uniform(0.0, 0.9)
        clean = table if i < controls else share * moved["one"] + (1 - share) * moved["two"]
        clean = clean[lead:]
        loudest = max(float(np.std(moved["one"][lead:])), float(np.std(clean)))
        noise = loudest * np.exp(rng.uniform(np.log(1e-4), np.log(1e-2)))
        rows.append(converted(clean + noise * rng.standard_normal(n), rng))
        role = "control" if i < controls else "response"
        channels.append(Channel(f"ch{i + 1}", "m/s^2", f"ch{i + 1}", "g", role))
    made = recording_of_arrays(f"run {seed}", channels, np.array(rows), rate)
    known = kind != "decay" and bool(rng.integers(2))  # by a log, or read without one
    return replace(made, driven=known), kind


def clip(samples, rng):
    """At a level that more than 1 % of the samples exceed."""
    limit = float(np.quantile(np.abs(samples), rng.uniform(0.6, 0.97)))
    return np.clip(samples, -limit, limit)


FAULTS = {
    "all zero": lambda x, _: np.zeros_like(x),
    "constant": lambda x, rng: np.full_like(x, rng.normal()),
    "unplugged": lambda x, rng: converted(OPEN * rng.standard_normal(x.size), rng),
    "saturated": clip,
    "dead control": lambda x, rng: converted(OPEN * rng.standard_normal(x.size), rng),
}


def found(fault, seed):
    """Whether the dead channel of a driven run is named, and no other one."""
    rng = np.random.default_rng([13, seed])
    while True:
        recording, kind = healthy_run(int(rng.integers(1_000_000)))
        roles = [channel.role for channel in recording.channels]
        wanted = "control" if fault == "dead control" else "response"
        if kind not in {"decay", "burst"} and wanted in roles and len(roles) > 2:
            break
    row = int(rng.choice([i for i, role in enumerate(roles) if role == wanted]))
    samples = recording.samples()
    samples[row] = FAULTS[fault](samples[row], rng)
    spoiled = recording_of_arrays("run", recording.channels, samples, recording.sample_rate)
    flags = health(replace(spoiled, driven=True))
    lost = {flag.channel for flag in unusable(flags, 0.0, spoiled.duration)}
    return lost == {recording.channels[row].name}


def spiked(samples, rng):
    """One of the first or last 32 samples 60 standard deviations off."""
    out, at = samples.copy(), int(rng.integers(32))
    out[at if rng.integers(2) else -1 - at] += 60.0 * np.std(samples)
    return out


def clipped_and_coupled(samples, rng):
    """Clip 20 to 40 % of the samples, then couple them by a high-pass of 1 part in 2000."""
    limit = float(np.quantile(np.abs(samples), rng.uniform(0.6, 0.8)))
    clipped = np.clip(samples, -limit, limit)
    return signal.lfilter(*signal.butter(1, 0.001, "high"), clipped)


TOLD = {
    "spike at an end": ("spike", spiked, 0.95),
    "wrong by ten": ("gain", lambda x, rng: x * 10.0 ** rng.choice([-1, 1]), 0.95),
    "clipped and coupled": (
        "short tails",
        clipped_and_coupled,
        0.35,
    ),  # half: a lightly damped mass tells little in 10 s
}
"""What is told of one response of a driven run: kind, fault, share that must be found."""


def is_told(fault, seed):
    """Whether one response of a random run of 8.5 s or more, with a control, is named."""
    rng = np.random.default_rng([14, seed])
    while True:
        recording, _ = healthy_run(len(KINDS) * int(rng.integers(200_000)))  # random ones
        roles = [channel.role for channel in recording.channels]
        if len(set(roles)) == 2 and recording.duration > 8.5:
            break
    row = int(rng.choice([i for i, role in enumerate(roles) if role == "response"]))
    samples = recording.samples()
    samples[row] = TOLD[fault][1](samples[row], rng)
    spoiled = recording_of_arrays("run", recording.channels, samples, recording.sample_rate)
    flags = health(replace(spoiled, driven=True))
    return {(f.kind, f.channel) for f in flags} == {
        (TOLD[fault][0], recording.channels[row].name)
    }


def main(count=500):
    """Print what is flagged of healthy runs, and what is missed of dead channels."""
    false = []
    for seed in range(count):
        recording, kind = healthy_run(seed)
        flags = health(recording)
        told = ", ".join(f"{flag.kind} ({flag.channel})" for flag in flags)
        if flags:
            false.append(f"run {seed}, {kind}, {len(recording.channels)} channels: {told}")
    sys.stdout.write(f"{count} healthy runs: {len(false)} flagged\n")
    sys.stdout.write("".join(f"  {line}\n" for line in false))
    each = max(1, count // 5)
    rarely = False
    for fault in FAULTS:
        not_found = [seed for seed in range(each) if not found(fault, seed)]
        rarely |= len(not_found) > (1.0 - LEAST_FOUND) * each
        sys.stdout.write(f"{fault}: {each - len(not_found)} of {each} found\n")
        if not_found:
            sys.stdout.write(f"  missed: {not_found}\n")
    for fault, (_, _, least) in TOLD.items():
        not_found = [seed for seed in range(each) if not is_told(fault, seed)]
        rarely |= len(not_found) > (1.0 - least) * each
        sys.stdout.write(f"{fault}: {each - len(not_found)} of {each} found\n")
        if not_found:
            sys.stdout.write(f"  missed: {not_found}\n")
    return 1 if false or rarely else 0


if __name__ == "__main__":
    sys.exit(main(*(int(text) for text in sys.argv[1:])))
