"""Health: silent on good recordings of every kind, and each fault found by its name."""

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from shakerproc.data import Channel, SampleSource, recording_of_arrays
from shakerproc.recordings import health, open_recording

RATE = 51200.0 / 9.0
N = 50_000


def recording_of(samples, rate=RATE, roles=("control", "control", "response", "response")):
    channels = [
        Channel(f"ch{i + 1}", "m/s^2", f"ch{i + 1}", "g", role)
        for i, role in zip(range(len(samples)), roles, strict=False)
    ]
    return recording_of_arrays("run", channels, np.asarray(samples, dtype=float), rate)


def kinds(samples, **options):
    return sorted({
        (flag.kind, flag.channel) for flag in health(recording_of(samples, **options))
    })


def sdof(base, natural=250.0, damping=0.02):
    """Absolute acceleration of a mass on a spring and damper, driven at its base."""
    omega = 2.0 * np.pi * natural
    system = ([2.0 * damping * omega, omega**2], [1.0, 2.0 * damping * omega, omega**2])
    b, a = signal.bilinear(*system, fs=RATE)
    return signal.lfilter(b, a, base)


def excitation(kind, rng, n=N):
    t = np.arange(n) / RATE
    return {
        "random": lambda: signal.lfilter(*signal.butter(2, 0.35), rng.standard_normal(n)),
        "white": lambda: rng.standard_normal(n),
        "sweep": lambda: 5.0 * signal.chirp(t, 5.0, t[-1], 500.0, method="logarithmic"),
        "sweep down": lambda: 5.0 * signal.chirp(t, 500.0, t[-1], 5.0, method="logarithmic"),
        "50 Hz": lambda: 10.0 * np.sin(2.0 * np.pi * 50.0 * t),
        "5 Hz": lambda: 10.0 * np.sin(2.0 * np.pi * 5.0 * t),
        "300 Hz": lambda: 10.0 * np.sin(2.0 * np.pi * 300.0 * t),
        "shock": lambda: 300.0 * np.sin(285.6 * (t - 2)) * (np.abs(t - 2.0055) < 0.0055),
        "random on sine": lambda: rng.standard_normal(n) + 8.0 * np.sin(2.0 * np.pi * 80.0 * t),
    }[kind]()  # fmt: skip


def four_channels(kind, rng, noise=0.01):
    base = excitation(kind, rng)
    clean = np.array([base, 1.02 * base, sdof(base), sdof(base, 180.0, 0.005)])
    return clean + noise * rng.standard_normal(clean.shape)


KINDS = [
    "random",
    "white",
    "sweep",
    "sweep down",
    "50 Hz",
    "5 Hz",
    "300 Hz",
    "shock",
    "random on sine",
]
STORAGE = {
    "double": lambda x: x,
    "single": lambda x: x.astype(np.float32).astype(float),
    "24 bit": lambda x: np.round(x / (500.0 / 2**23)) * (500.0 / 2**23),
    "16 bit": lambda x: np.round(x / (500.0 / 2**15)) * (500.0 / 2**15),
    "coarse": lambda x: np.round(x / 0.5) * 0.5,
    "offset": lambda x: x + 0.11,
}


@pytest.mark.parametrize("storage", STORAGE)
@pytest.mark.parametrize("kind", KINDS)
def test_silent_on_a_good_recording(kind, storage):
    samples = four_channels(kind, np.random.default_rng(7))
    assert kinds(STORAGE[storage](samples)) == []


@pytest.mark.parametrize("kind", KINDS)
def test_silent_on_a_simulation_without_noise(kind):
    assert kinds(four_channels(kind, np.random.default_rng(7), noise=0.0)) == []


def test_silent_on_a_simulation_that_rests_before_and_after():
    rng = np.random.default_rng(8)
    samples = four_channels("sweep", rng, noise=0.0)
    pause = np.zeros((4, 5000))
    assert kinds(np.concatenate([pause, samples, pause], axis=1)) == []


@pytest.mark.parametrize("seed", range(8))
def test_silent_on_noise_of_any_tail(seed):
    rng = np.random.default_rng(seed)
    heavy = signal.lfilter(*signal.butter(2, 0.4), rng.laplace(size=(4, N)))
    heavy[1:] = heavy[0] + 0.1 * heavy[1:]
    assert kinds(heavy) == []


@pytest.mark.shared
def test_silent_on_the_reference_recordings(shared):
    for path in sorted((shared / "reference" / "recordings").glob("*.tdms")):
        with open_recording(path) as recording:
            assert health(recording) == ()


def put(where, value):
    """Return what writes a value into channel 3."""

    def change(x, rng):
        x[2, where] = value(x[2], rng) if callable(value) else value

    return change


def hum(mains):
    def samples(x, rng):
        t = np.arange(x.size) / RATE
        tone = 0.02 * np.sin(2 * np.pi * mains * t) + 0.004 * np.sin(6 * np.pi * mains * t)
        return tone + 2e-4 * rng.standard_normal(x.size)

    return put(slice(None), samples)


def dropouts(x, rng):
    for start in range(5000, 50_000, 900):
        x[2, start : start + 40] = 0.0


FAULTS = {
    "zero tail": ("zero tail", put(slice(-700, None), 0.0)),
    "short zero tail": ("zero tail", put(slice(-9, None), 0.0)),
    "stuck": ("stuck", put(slice(30_000, None), lambda x, _: x[30_000])),
    "constant": ("constant", put(slice(None), 3.2)),
    "dropout": ("dropout", put(slice(20_000, 20_080), 0.0)),
    "dropouts": ("dropout", dropouts),
    "repeating": (
        "repeating",
        put(slice(31_000, 33_000), lambda x, _: x[29_000:31_000].copy()),
    ),
    "clipping": (
        "clipping",
        put(slice(None), lambda x, _: np.clip(x, -0.6 * x.max(), 0.6 * x.max())),
    ),
    "clipping above": ("clipping", put(slice(None), lambda x, _: np.minimum(x, 0.8 * x.max()))),
    "not a number": ("not a number", put(slice(777, 790), np.nan)),
    "infinite": ("not a number", put(12_345, np.inf)),
    "spike": ("spike", put(40_001, lambda x, _: x[40_001] + 40.0 * np.std(x))),
    "wide spike": ("spike", put(slice(40_001, 40_004), lambda x, _: -60.0 * np.std(x))),
    "drift": (
        "drift",
        put(slice(None), lambda x, _: x + 2.0 * np.std(x) * np.arange(x.size) / x.size),
    ),
    "open input": ("open input", hum(50.0)),
    "open input 60": ("open input", hum(60.0)),
    "polarity": ("polarity", put(slice(None), lambda x, _: -x)),
}


def faulty(names, x, rng):
    for name in names:
        FAULTS[name][1](x, rng)
    return x


@pytest.mark.parametrize("storage", ["double", "24 bit"])
@pytest.mark.parametrize("kind", ["random", "sweep", "random on sine"])
@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_found_and_nothing_else(name, kind, storage):
    rng = np.random.default_rng(11)
    samples = STORAGE[storage](four_channels(kind, rng))
    assert kinds(faulty([name], samples, rng)) == [(FAULTS[name][0], "ch3")]


def test_block_size_does_not_matter():
    rng = np.random.default_rng(12)
    names = ("clipping", "dropout", "zero tail", "spike", "repeating")
    samples = faulty(names, four_channels("random", rng), rng)
    recording = recording_of(samples)
    found = {kind.kind for kind in health(recording, block=1 << 20)}
    assert found >= {"dropout", "zero tail", "repeating"}
    for block in (4096, 10_000, 33_333):
        again = health(recording, block=block)
        assert {kind.kind for kind in again} == found


def test_times_are_those_of_the_fault():
    rng = np.random.default_rng(13)
    samples = faulty(["dropout"], four_channels("random", rng), rng)
    (flag,) = health(recording_of(samples))
    assert flag.start == pytest.approx(20_000 / RATE)
    assert flag.stop == pytest.approx(20_080 / RATE)
    assert "80 samples" in flag.message


def test_controls_that_differ_are_named_with_both_values():
    rng = np.random.default_rng(14)
    samples = four_channels("random", rng)
    samples[1] *= 1.1 / 1.02 * 1.03
    (flag,) = health(recording_of(samples))
    assert (flag.kind, flag.channel) == ("controls differ", "ch1")
    assert "ch1 and ch2" in flag.message


def test_a_turned_second_control_is_found():
    rng = np.random.default_rng(15)
    samples = four_channels("sweep", rng)
    samples[1] *= -1.0
    assert ("polarity", "ch2") in kinds(samples)


def test_a_slow_channel_whose_values_are_held_is_not_stuck():
    rng = np.random.default_rng(19)
    samples = four_channels("random", rng)
    samples[2] = np.repeat(samples[2, ::20], 20)[:N]
    assert kinds(samples) == []


def test_a_jolt_that_two_sensors_feel_is_no_spike():
    samples = four_channels("random", np.random.default_rng(22))
    samples[2:, 40_001] += 40.0 * np.std(samples[2:], axis=1)
    assert kinds(samples) == []


def test_a_response_past_its_resonance_is_not_turned_round():
    rng = np.random.default_rng(23)
    t = np.arange(N) / RATE
    base = 5.0 * signal.chirp(t, 60.0, t[-1], 500.0, method="logarithmic")
    rows = np.array([base, base, sdof(base, 20.0), sdof(base, 30.0)])
    assert kinds(rows + 1e-3 * rng.standard_normal(rows.shape)) == []
    rows[2] = -sdof(base, 600.0)
    assert kinds(rows + 1e-3 * rng.standard_normal(rows.shape)) == [("polarity", "ch3")]


def test_controls_at_rest_do_not_differ_by_their_noise():
    rng = np.random.default_rng(24)
    samples = rng.standard_normal((3, N)) * [[0.01], [0.02], [0.01]]
    samples[2] += 50.0 * np.exp(-np.arange(N) / 9000.0) * np.sin(0.3 * np.arange(N))
    assert kinds(samples, roles=("control", "control", "response")) == []


def test_a_decay_that_ends_within_a_step_of_the_converter_is_no_zero_tail():
    rng = np.random.default_rng(25)
    t = np.arange(N)
    clean = np.exp(-t / 2000.0) * np.sin(0.2 * t) * np.array([[900.0], [700.0]])
    samples = np.round(clean + 0.05 * rng.standard_normal(clean.shape))
    assert kinds(samples, roles=("response", "response")) == []


def test_impacts_in_series_are_not_spikes():
    rng = np.random.default_rng(16)
    samples = four_channels("300 Hz", rng)
    samples[2, 20_000:21_000:19] += 40.0 * np.std(samples[2])
    assert kinds(samples) == []


def test_a_file_that_stops_short_is_flagged():
    recording = recording_of(four_channels("random", np.random.default_rng(17)))
    (flag,) = health(replace(recording, expected_samples=2 * N))
    assert flag.kind == "incomplete"
    assert flag.message.startswith("The file ends after 8.78906 s of 17.5781 s")


@pytest.mark.parametrize("kind", ["random", "sweep", "random on sine"])
def test_a_knock_on_one_control_is_found_and_one_on_the_table_is_none(kind):
    samples = four_channels(kind, np.random.default_rng(20))
    after = np.exp(-np.arange(N - 20_000) / RATE / 0.0008)
    knock = 30.0 * np.std(samples[:2], axis=1, keepdims=True) * after
    samples[1, 20_000:] += knock[1]
    assert kinds(samples) == [("transient", "ch2")]
    samples[[0, 2, 3], 20_000:] += knock[0]
    assert kinds(samples) == []


def test_the_knock_of_the_sample_campaign_is_found():
    folder = Path(__file__).parents[2] / "sample_data" / "recordings"
    if not folder.is_dir():
        pytest.skip("no sample data")
    found = {}
    for path in folder.glob("*/*.tdms"):
        with open_recording(path) as recording:
            found[path.parent.name] = {(flag.kind, flag.channel) for flag in health(recording)}
    assert found.pop("Test_13") == {("transient", "control 2")}
    assert found.pop("Test_11") == {("incomplete", "")}
    assert set.union(*found.values()) == set()


@pytest.mark.parametrize("n", [1, 2, 3, 8, 17, 40, 300])
def test_short_recordings_are_no_trouble(n):
    rng = np.random.default_rng(18)
    assert kinds(rng.standard_normal((4, n)), roles=(None,) * 4) == []


def test_a_long_recording_that_repeats_itself_takes_little_memory():
    """Eight channels of the same second again and again, as a test signal from a table has."""
    rng = np.random.default_rng(8)
    second = rng.standard_normal((8, 2**15))

    class Source(SampleSource):
        def read(self, rows, start, stop):
            return second[list(rows)][:, np.arange(start, stop) % second.shape[1]]

        def close(self):
            pass

    one = recording_of(second, roles=["response"] * 8)
    recording = replace(one, source=Source(), n_samples=2**21)
    tracemalloc.start()
    health(recording)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    block = 8 * 8 * 2**17
    assert peak < 6 * block, f"{peak / 1e6:.0f} MB"


@pytest.mark.parametrize("rate", [1e-300, 1e-3, 0.3, 0.4, 1e12, 1e300, 1.7e308])
def test_no_sample_rate_is_too_slow_or_too_fast_to_be_looked_at(rate):
    channels = [Channel(name, "N", name, "N") for name in ("control", "a")]
    samples = np.random.default_rng(3).standard_normal((2, 5000))
    recording = recording_of_arrays("run", channels, samples, rate)
    assert all(flag.message for flag in health(recording))


def test_a_rate_given_against_the_times_of_the_file_is_flagged(tmp_path):
    """500 of 8000 rows are missing; a file without times leaves the rate to the log."""
    values = np.random.default_rng(3).standard_normal(8000)
    rows = [f"{i / 2000.0:.4f},{value:.6f}" for i, value in enumerate(values)]
    gap = tmp_path / "gap.csv"
    gap.write_text("\n".join(["t [s],a [g]", *rows[:3000], *rows[3500:]]) + "\n")
    silent = tmp_path / "silent.csv"
    silent.write_text("\n".join(["a [g]", *(row.split(",")[1] for row in rows)]) + "\n")
    with open_recording(gap, sample_rate=2000.0) as recording:
        (flag,) = health(recording)
    assert flag.kind == "sample rate"
    assert "does not advance evenly: from sample 2999 to 3000" in flag.message
    with open_recording(silent, sample_rate=2000.0) as recording:
        assert health(recording) == ()


def stuck(n=20_000, step=1e-5):
    """A slider under a force of 10 Hz and dry friction, by an encoder, stuck at its ends."""
    quarter = np.arange(0, 40) / 40.0
    way = np.concatenate([1.0 - (1.0 - quarter) ** 2, np.ones(60)])  # brakes evenly, stands
    period = np.concatenate([way, 1.0 - way]) * 1e-3
    return step * np.round(np.tile(period, n // period.size) / step)


def held(n=20_000, step=5e-5):
    """A pendulum that is held at its largest angle and let go."""
    t = np.maximum(np.arange(n) / 1000.0 - 0.8, 0.0)
    return step * np.round(0.3 * np.exp(-0.05 * t) * np.cos(4.0 * t) / step)


@pytest.mark.parametrize("motion", [stuck, held])
def test_what_rests_at_its_largest_displacement_is_not_clipped(motion):
    samples = motion()
    channel = Channel("way", "m", "way", "m", "displacement")
    for limit, flagged in ((np.inf, False), (0.6 * samples.max(), True)):
        recording = recording_of_arrays(
            "run", [channel], np.minimum(samples, limit)[np.newaxis], 1000.0
        )
        assert ("clipping" in {flag.kind for flag in health(recording)}) is flagged
