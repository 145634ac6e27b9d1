"""The time axis of every format: what a file states is used, or told to be unclear.

Each file is written from a signal whose rate and start are known, by other programs where there
are some (npTDMS, pyarrow, scipy) or by hand as the format is defined.
"""

from datetime import UTC, datetime, timedelta

import numpy as np
import pyarrow as pa
import pytest
from nptdms import ChannelObject, TdmsWriter
from numpy.testing import assert_allclose
from pyarrow import parquet
from scipy import io as scipy_io
from tests.modal.function_files import copied_table

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import Sampling, contents, file_flags, open_recording
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis, half_digit
from shakerproc.recordings.time_base import time_base

RATE = 2000.0
N = 1500
TIMES = np.arange(N) / RATE
WAVE = np.round(np.sin(2.0 * np.pi * 37.0 * TIMES), 6)
START = datetime(2018, 7, 5, 23, 59, 59, 500000, tzinfo=UTC)


def csv(tmp_path, head, times, values=WAVE):
    path = tmp_path / "run.csv"
    rows = (f"{t},{v:.6f}" for t, v in zip(times, values, strict=True))
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


def tdms(tmp_path, **channels):
    """Write channels, each a pair of values and properties, by npTDMS."""
    path = tmp_path / "run.tdms"
    with TdmsWriter(str(path)) as writer:
        writer.write_segment([
            ChannelObject("g", name, values, {"unit_string": "g", **properties})
            for name, (values, properties) in channels.items()
        ])
    return path


def uff(tmp_path, *, step=1.0 / RATE, unit="s", kind=17, starts=(0.0, 0.0), times=None):
    """Write two records of dataset 58 as its definition has them."""
    lines = []
    for name, start in zip(("a", "b"), starts, strict=True):
        even, pair = (1, WAVE) if times is None else (0, np.stack([times, WAVE], 1).ravel())
        axis = f"{kind:10d}{0:5d}{0:5d}{0:5d} {'':20} {unit:20}"
        other = f"{12:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {'g':20}"
        none = f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {'NONE':20}"
        lines += [
            "    -1", "    58", name, "NONE", "NONE", "NONE", "NONE",
            f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':10}{1:10d}{0:4d} {'NONE':10}{0:10d}{0:4d}",
            f"{4:10d}{N:10d}{even:10d}{start:13.5e}{step if even else 0.0:13.5e}{0.0:13.5e}",
            axis, other, none, none,
        ]  # fmt: skip
        cells = [f"{value:20.12e}" for value in pair]
        lines += ["".join(cells[at : at + 4]) for at in range(0, len(cells), 4)]
        lines.append("    -1")
    path = tmp_path / "run.uff"
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def refusal(path, said=None):
    with pytest.raises(RecordingError) as caught:
        open_recording(path, sample_rate=said)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def assert_read(path, said=None, *, rate=RATE):
    with open_recording(path, sample_rate=said) as recording:
        assert recording.sample_rate == pytest.approx(rate, rel=1e-9)
        assert_allclose(recording.samples()[0], WAVE * STANDARD_GRAVITY, atol=1e-9)
        return recording


UNITS = {
    "s": 1.0,
    "ms": 1e3,
    "us": 1e6,
    "ns": 1e9,
    "min": 1 / 60,
    "h": 1 / 3600,
    "d": 1 / 86400,
}


@pytest.mark.parametrize(
    ("head", "unit"),
    [(f"t [{unit}]", unit) for unit in UNITS]
    + [("time_ms", "ms"), ("millis", "ms"), ("Time (us)", "us"), ("micros", "us")]
    + [("elapsed", "s"), ("seconds", "s")],
)
def test_times_are_read_in_the_unit_that_header_or_name_says(tmp_path, head, unit):
    times = [repr(float(t)) for t in 1.25 + TIMES]
    times = [repr(float(t) * UNITS[unit]) for t in times]
    assert_read(csv(tmp_path, f"{head},a [g]", times))


@pytest.mark.parametrize("per_second", [1.0, 1e3, 1e6, 1e9])
def test_epoch_times_are_known_by_their_size_and_give_the_start(tmp_path, per_second):
    ticks = [f"{round((START.timestamp() + t) * 1e9)}" for t in TIMES]
    digits = {1.0: 9, 1e3: 6, 1e6: 3, 1e9: 0}[per_second]
    times = [t if not digits else f"{t[:-digits]}.{t[-digits:]}" for t in ticks]
    with open_recording(csv(tmp_path, "Timestamp,a [g]", times)) as recording:
        assert recording.sample_rate == pytest.approx(RATE, rel=1e-6)
        assert abs((recording.start_time - START).total_seconds()) < 1e-5
        assert any("by their size" in note for note in recording.notes)


def test_times_without_a_unit_are_an_error_that_shows_both_readings(tmp_path):
    path = csv(tmp_path, "time,a [g]", 1234 + 2 * np.arange(N))
    assert "0.5 Hz in s, 500 Hz in ms" in refusal(path)
    assert "time_unit: ms" in refusal(path)
    assert_read(path, Sampling(unit="ms"), rate=500.0)
    assert_read(path, Sampling(500.0), rate=500.0)
    assert_read(path, Sampling(0.5), rate=0.5)
    assert "Say which" in refusal(path, Sampling(800.0))
    assert_read(path, Sampling(800.0, override=True), rate=800.0)


def test_a_vector_of_milliseconds_in_matlab_is_told_apart_by_the_rate_beside_it(tmp_path):
    path = tmp_path / "run.mat"
    scipy_io.savemat(path, {"time": 1e3 * TIMES, "a_g": WAVE})
    assert "2 Hz in s or 2000 Hz in ms" in refusal(path)
    scipy_io.savemat(path, {"time": 1e3 * TIMES, "fs": RATE, "a_g": WAVE})
    assert_read(path)


def test_the_unit_of_the_abscissa_counts_in_tdms_and_uff(tmp_path):
    step = {"wf_increment": 0.5, "wf_xunit_string": "ms", "wf_xname": "Time"}
    assert_read(tdms(tmp_path, a=(WAVE, step)))
    assert_read(uff(tmp_path, step=0.5, unit="ms"))


@pytest.mark.parametrize("rate", [10.0, 0.2, 5e6])
def test_the_interval_of_a_waveform_is_in_seconds_where_its_axis_has_no_unit(tmp_path, rate):
    """As NI defines wf_increment, however slow or fast the channel is."""
    path = tdms(tmp_path, a=(WAVE, {"wf_increment": 1.0 / rate}))
    with open_recording(path) as recording:
        assert recording.sample_rate == pytest.approx(rate, rel=1e-12)
        assert recording.rate_doubtful == ""


def test_a_step_of_one_is_what_labview_writes_and_can_be_corrected(tmp_path):
    path = tdms(tmp_path, a=(WAVE, {"wf_increment": 1.0}))
    assert "1 as LabVIEW writes it where none is given" in refusal(path)
    with open_recording(path, sample_rate=Sampling(RATE, override=True)) as recording:
        assert recording.sample_rate == RATE
        assert recording.notes[0].startswith("The sample rate is 2000 Hz by override")
        assert [flag.kind for flag in file_flags(recording)] == ["sample rate"]


def test_a_stated_rate_is_corrected_by_override_alone(tmp_path):
    path = tdms(tmp_path, a=(WAVE, {"wf_increment": 1.0 / 1000.0}))
    message = refusal(path, Sampling(RATE))
    assert "says 1000 samples per second, the log 2000" in message
    assert "override: true" in message
    recording = assert_read(path, Sampling(RATE, override=True))
    assert "in the file: 1000 Hz" in recording.rate_doubtful


LVM = """LabVIEW Measurement
Separator\tTab
Decimal_Separator\t.
***End_of_Header***
Channels\t1
Samples\t{n}
Y_Unit_Label\tg
X_Dimension\t{quantity}
X0\t0.0
Delta_X\t{step}
***End_of_Header***
X_Value\ta\tComment
"""


def lvm(tmp_path, step, quantity="Time"):
    path = tmp_path / "run.lvm"
    head = LVM.format(n=N, step=step, quantity=quantity)
    path.write_text(head + "".join(f"\t{v:.6f}\n" for v in WAVE), encoding="utf-8")
    return path


def test_a_rounded_step_is_told_with_the_rate_that_it_may_be(tmp_path):
    """0.000977 s is 1/1024 s, printed to six decimals."""
    with open_recording(lvm(tmp_path, "0.000977")) as recording:
        assert recording.sample_rate == pytest.approx(1.0 / 0.000977)
        assert "perhaps 1024 Hz" in recording.notes[0]
        assert abs(recording.sample_rate / 1024.0 - 1.0) <= recording.rate_doubt
    assert_read(lvm(tmp_path, "0.000977"), Sampling(1024.0), rate=1024.0)
    with open_recording(lvm(tmp_path, "0.0005")) as recording:
        assert (recording.sample_rate, recording.notes) == (2000.0, ())


def test_a_spectrum_is_refused_as_one(tmp_path):
    frequency = {"wf_increment": 0.5, "wf_xname": "Frequency", "wf_xunit_string": "Hz"}
    for path in (
        tdms(tmp_path, a=(WAVE, frequency)),
        lvm(tmp_path, "0.5", "Frequency"),
        uff(tmp_path, step=0.5, unit="Hz", kind=18),
        uff(tmp_path, step=0.5, unit="Hz", kind=17),
    ):
        assert "it is a spectrum, not samples over time" in refusal(path)
        assert "Export the samples over time" in refusal(path)


@pytest.mark.parametrize("ending", [".csv", ".xlsx", ".parquet"])
@pytest.mark.parametrize("header", ["frequency [Hz]", "Frequency (Hz)", "Frequenz", "f [Hz]"])
def test_a_table_over_frequencies_is_a_spectrum_whatever_the_log_says(tmp_path, ending, header):
    path = tmp_path / "run.csv"
    lines = [f"{20 + 0.5 * i},{0.1 * i % 0.7:.3f}" for i in range(50)]
    path.write_text("\n".join([f"{header},control [g]", *lines]) + "\n")
    path = path if ending == ".csv" else copied_table(path, ending)
    for rate in (None, 1000.0):
        told = refusal(path, rate)
        assert "channel 'control' is no recording: it is a spectrum" in told


def test_a_measured_frequency_is_a_channel(tmp_path):
    """It does not rise with every sample."""
    path = tmp_path / "run.csv"
    rows = [f"{20 + i * i % 31},{0.1 * i % 0.7:.3f}" for i in range(50)]
    path.write_text("\n".join(["frequency [Hz],control [g]", *rows]) + "\n")
    with open_recording(path, sample_rate=1000.0) as found:
        assert [c.name for c in found.channels] == ["frequency", "control"]


def test_a_spectrum_beside_a_recording_is_left_out(tmp_path):
    path = tmp_path / "run.tdms"
    over_time = {"wf_increment": 1.0 / RATE, "unit_string": "g"}
    over_frequency = over_time | {"wf_xname": "Frequency", "wf_xunit_string": "Hz"}
    with TdmsWriter(str(path)) as writer:
        writer.write_segment([
            ChannelObject("time", "a", WAVE, over_time),
            ChannelObject("spectra", "a", WAVE, over_frequency),
        ])
    assert_read(path)


@pytest.mark.parametrize("late", [8, 0, 700])
def test_starts_that_channels_state_are_applied(tmp_path, late):
    """Both channels hold one wave; b begins some samples later."""
    wave = np.concatenate([WAVE, -WAVE])
    begin = np.datetime64("2024-03-05T10:11:12")
    step = {"wf_increment": 1.0 / RATE}
    after = begin + np.timedelta64(late * 500, "us")
    for properties in (
        {"wf_start_time": after},
        {"wf_start_time": begin, "wf_start_offset": late / RATE},
    ):
        path = tdms(
            tmp_path,
            a=(wave[:N], step | {"wf_start_time": begin}),
            b=(wave[late : late + N], step | properties),
        )  # fmt: skip
        with open_recording(path) as recording:
            a, b = recording.samples()
            assert_allclose(a, b)
            assert recording.n_samples == N - late
            begun = recording.start_time - datetime(2024, 3, 5, 10, 11, 12, tzinfo=UTC)
            assert begun.total_seconds() == pytest.approx(late / RATE, abs=2e-6)
            assert bool(recording.notes) == bool(late)


def test_starts_are_ignored_on_request_and_told(tmp_path):
    """Two tasks that one clock took, with stamps 0.0371 s apart."""
    begin = np.datetime64("2024-03-05T10:11:12")
    step = {"wf_increment": 1.0 / RATE, "wf_start_time": begin}
    path = tdms(tmp_path, a=(WAVE, step), b=(WAVE, step | {"wf_start_offset": 0.0371}))
    message = refusal(path)
    assert "resample: 2000 Hz" in message
    assert "starts: ignore" in message
    with open_recording(path, sample_rate=Sampling(ignore_starts=True)) as recording:
        a, b = recording.samples()
        assert_allclose(a, b)
        assert recording.n_samples == N
        assert recording.start_time == datetime(2024, 3, 5, 10, 11, 12, tzinfo=UTC)
        (note,) = recording.notes
        assert "ignored" in note
        assert "0.0371 s" in note
    both = Sampling(ignore_starts=True, resample=RATE)
    with open_recording(path, sample_rate=both) as recording:
        a, b = recording.samples()
        assert_allclose(a, b)
        late = recording.start_time - datetime(2024, 3, 5, 10, 11, 12, tzinfo=UTC)
        shift = late.total_seconds() * RATE
        wave = WAVE[round(shift) :][: recording.n_samples]
        assert_allclose(a, wave * STANDARD_GRAVITY, atol=1e-3 * STANDARD_GRAVITY)


def test_an_offset_without_a_date_counts(tmp_path):
    step = {"wf_increment": 1.0 / RATE}
    path = tdms(tmp_path, a=(WAVE, step), b=(WAVE[9:], step | {"wf_start_offset": 9 / RATE}))
    with open_recording(path) as recording:
        a, b = recording.samples()
        assert_allclose(a, b)
        assert recording.n_samples == N - 9


def test_channels_of_two_rates_are_brought_to_one_on_request(tmp_path):
    """One sine, sampled at both rates."""
    slow = np.sin(2.0 * np.pi * 37.0 * np.arange(N // 2) / (RATE / 2.0))
    path = tdms(
        tmp_path,
        a=(WAVE, {"wf_increment": 1.0 / RATE}),
        b=(slow, {"wf_increment": 2.0 / RATE}),
    )
    assert "resample: 2000 Hz" in refusal(path)
    with open_recording(path, sample_rate=Sampling(resample=RATE)) as recording:
        a, b = recording.samples()
        assert_allclose(a, b, atol=1e-3 * STANDARD_GRAVITY)


@pytest.mark.parametrize("day", ["", "2018-07-05 "])
@pytest.mark.parametrize("places", [0, 2])
def test_stamps_coarser_than_a_step_tell_the_start_and_ask_for_the_rate(tmp_path, day, places):
    """As Excel shows 09:24:51 on rows of a fast recording."""
    begin = datetime(2018, 7, 5, 9, 24, 51, 800000, tzinfo=UTC)
    wave = np.tile(WAVE, 3)
    moments = [begin + timedelta(seconds=i / RATE) for i in range(wave.size)]
    cut = -6 + places if places else -7
    stamps = [day + f"{m:%H:%M:%S.%f}"[:cut] for m in moments]
    path = csv(tmp_path, "time,a [g]", stamps, wave)
    message = refusal(path)
    assert f"rounded to {10.0**-places:g} s" in message
    assert "sample_rate: " in message
    with open_recording(path, sample_rate=RATE) as recording:
        assert_allclose(recording.samples()[0], wave * STANDARD_GRAVITY)
        assert not recording.rate_doubtful
        assert any("start is good to" in note for note in recording.notes)
        if day:
            away = (begin - recording.start_time).total_seconds()
            assert 0.0 <= away < 10.0**-places
    with open_recording(path, sample_rate=RATE / 2.0) as recording:
        assert "repeats its times" in recording.rate_doubtful


def test_starts_of_universal_files_are_applied(tmp_path):
    path = uff(tmp_path, starts=(0.0, 0.1))
    with open_recording(path) as recording:
        assert recording.n_samples == N - 200
        a, b = recording.samples()
        assert_allclose(a, WAVE[200:] * STANDARD_GRAVITY)
        assert_allclose(b, WAVE[: N - 200] * STANDARD_GRAVITY)


def test_starts_a_part_of_a_sample_apart_are_resampled_on_request(tmp_path):
    """The same sine in both, taken 0.3 samples later in b."""
    late = 0.3 / RATE
    step = {"wf_increment": 1.0 / RATE, "wf_start_time": np.datetime64("2024-03-05T10:11:12")}
    wave = [np.sin(2.0 * np.pi * 317.0 * (TIMES + shift)) for shift in (0.0, late)]
    path = tdms(tmp_path, a=(wave[0], step), b=(wave[1], step | {"wf_start_offset": late}))
    assert "starts 0.00015 s after 'a': 0.3 samples" in refusal(path)
    assert "resample: 2000 Hz" in refusal(path)
    with open_recording(path, sample_rate=Sampling(resample=RATE)) as recording:
        a, b = recording.samples()
        assert_allclose(a, b, atol=1e-4 * STANDARD_GRAVITY)
        assert np.abs(a).max() == pytest.approx(STANDARD_GRAVITY, rel=1e-3)


def test_times_that_a_universal_file_stores_are_used(tmp_path):
    assert_read(uff(tmp_path, times=TIMES))
    assert_read(uff(tmp_path, times=1e3 * TIMES, unit="ms"))
    assert "says 2000 samples per second" in refusal(
        uff(tmp_path, times=TIMES), Sampling(900.0)
    )


def test_a_channel_of_times_is_that_of_the_others_in_tdms(tmp_path):
    stamps = np.datetime64(START.replace(tzinfo=None)) + (TIMES * 1e6).astype("timedelta64[us]")
    recording = assert_read(tdms(tmp_path, Time=(stamps, {}), a=(WAVE, {})))
    assert recording.start_time == START
    assert [c.name for c in recording.channels] == ["a"]
    assert_read(tdms(tmp_path, t_ms=(1e3 * TIMES, {"unit_string": ""}), a=(WAVE, {})))


def stamps(form, decimal="."):
    """Times of day as a logger prints them, over midnight."""
    moments = [START + timedelta(seconds=float(t)) for t in TIMES]
    return [f"{m:{form}}{decimal}{m.microsecond:06d}" for m in moments]


@pytest.mark.parametrize(
    ("head", "form", "start"),
    [
        ("Time,a [g]", "%H:%M:%S", None),
        ("x,a [g]", "%M:%S", None),
        ("time,a [g]", "%Y-%m-%d %H:%M:%S", START),
        ("Date,Time,a [g]", "%Y-%m-%d,%H:%M:%S", START),
        ("Date/Time,a [g]", "%d.%m.%Y %H:%M:%S", START),
        ("Zeit,a [g]", "%d/%m/%Y %H:%M:%S", None),
        ("time,a [g]", "%Y-%m-%dT%H:%M:%S", START),
    ],
)
def test_dates_and_clock_times_in_text_are_read_over_midnight(tmp_path, head, form, start):
    recording = assert_read(csv(tmp_path, head, stamps(form)))
    assert recording.start_time == start
    assert [channel.name for channel in recording.channels] == ["a"]


def test_clock_times_with_decimal_commas_stand_beside_such_numbers(tmp_path):
    path = tmp_path / "run.csv"
    rows = [
        f"{t};{v:.6f}".replace(".", ",")
        for t, v in zip(stamps("%H:%M:%S", ","), WAVE, strict=True)
    ]
    path.write_text("\n".join(["Zeit;a [g]", *rows]) + "\n", encoding="utf-8")
    assert_read(path)


def test_a_stamp_that_is_lost_or_broken_is_seen(tmp_path):
    times = stamps("%H:%M:%S")
    assert "does not advance evenly" in refusal(
        csv(tmp_path, "Time,a [g]", times[:700] + times[701:], np.delete(WAVE, 700))
    )
    times[700] = "25:61:00"
    assert "line 702" in refusal(csv(tmp_path, "Time,a [g]", times))


@pytest.mark.parametrize(
    ("kind", "start"),
    [(pa.timestamp("ns"), START), (pa.timestamp("us"), START), (pa.time64("us"), None),
     (pa.duration("us"), None)],
)  # fmt: skip
def test_dates_and_times_in_parquet_are_used(tmp_path, kind, start):
    zero = 0.0 if start is None else START.timestamp()
    per_second = 10**9 if str(kind).endswith("[ns]") else 10**6
    ticks = [round(zero * per_second) + i * per_second // 2000 for i in range(N)]
    table = pa.table({"when": pa.array(ticks, pa.int64()).cast(kind), "a [g]": WAVE})
    parquet.write_table(table, tmp_path / "run.parquet")
    assert assert_read(tmp_path / "run.parquet").start_time == start


def uneven(tmp_path, frequency, share=0.2):
    """A sine whose samples were taken up to a share of a step off their place."""
    rng = np.random.default_rng(7)
    times = TIMES + rng.uniform(-share, share, N) / RATE
    path = tmp_path / "run.csv"
    rows = (f"{t:.9f},{np.sin(2.0 * np.pi * frequency * t):.12f}" for t in np.round(times, 9))
    path.write_text("t [s],a [m/s^2]\n" + "\n".join(rows) + "\n", encoding="utf-8")
    edge = 4.0 * np.diff(times).max()  # a spline ends badly
    return path, float(np.round(times[0], 9)) + edge


@pytest.mark.parametrize("rate", [4000.0, 2000.0, 1000.0])
def test_uneven_times_are_resampled_within_the_band_that_is_told(tmp_path, rate):
    """A sine at the end of the band: the interpolation is right to 1 % of it."""
    path, first = uneven(tmp_path, 300.0)
    assert "its times stray by 11" in refusal(path)
    assert "resample: 2000 Hz" in refusal(path)
    with open_recording(path, sample_rate=Sampling(resample=rate)) as recording:
        found = recording.samples()[0]
        (note,) = recording.notes
        edge = 32 / rate if rate == 1000.0 else 0.0
        times = first + edge + np.arange(recording.n_samples) / rate
        assert_allclose(found, np.sin(2.0 * np.pi * 300.0 * times), atol=0.02)
        assert float(note.split("up to ")[1].split(" Hz")[0]) == pytest.approx(315.0, rel=0.03)
        assert "vary by 16" in note


def test_what_is_above_half_of_a_lower_rate_is_filtered_away(tmp_path):
    path, _ = uneven(tmp_path, 400.0)
    with open_recording(path, sample_rate=Sampling(resample=500.0)) as recording:
        assert np.abs(recording.samples()).max() < 0.02


def test_a_gap_in_uneven_times_is_flagged(tmp_path):
    rng = np.random.default_rng(3)
    times = np.delete(TIMES + rng.uniform(-0.1, 0.1, N) / RATE, slice(600, 610))
    path = csv(
        tmp_path, "t [s],a [g]", [f"{t:.9f}" for t in times], np.delete(WAVE, slice(600, 610))
    )
    with open_recording(path, sample_rate=Sampling(resample=RATE)) as recording:
        (flag,) = (f for f in file_flags(recording) if f.kind == "sample rate")
        assert "1 step is longer than two others" in flag.message


def test_times_rounded_in_print_are_no_uneven_times(tmp_path):
    """Three decimals at 600 Hz: steps of 1 and 2 ms, all from rounding."""
    times = [f"{i / 600.0:.3f}" for i in range(N)]
    with open_recording(csv(tmp_path, "t [s],a [g]", times)) as recording:
        assert recording.sample_rate == pytest.approx(600.0, rel=1e-3)
    times = [f"{99.0 + i / 5120.0:.8g}" for i in range(N)]  # five decimals from 100 s on
    with open_recording(csv(tmp_path, "t [s],a [g]", times)) as recording:
        assert recording.sample_rate == pytest.approx(5120.0, rel=1e-4)
    as_singles = np.arange(N, dtype=np.float32) * np.float32(1.0 / RATE) + np.float32(100.0)
    scipy_io.savemat(tmp_path / "run.mat", {"t": as_singles, "a_g": WAVE})
    with open_recording(tmp_path / "run.mat") as recording:
        assert recording.sample_rate == pytest.approx(RATE, rel=1e-4)


def test_statements_that_contradict_each_other_are_listed_with_their_places():
    axes = (TimeAxis("here", rate=100.0), TimeAxis("there", step=0.02, unit="s"))
    found = time_base(axes)
    assert found.sample_rate is None
    assert found.problem == "the file contradicts itself: 100 Hz (here), 50 Hz (there)"


@pytest.mark.parametrize("at", [0, 79])
def test_one_time_that_strays_at_an_end_does_not_make_another_rate(tmp_path, at):
    """As `make fuzz` found it: the ends alone gave 999 Hz."""
    times = np.arange(80) / 1000.0
    times[at] += 6.1e-5
    scipy_io.savemat(tmp_path / "run.mat", {"time": times, "a": WAVE[:80]})
    with open_recording(tmp_path / "run.mat") as recording:
        assert recording.sample_rate == 1000.0


def test_half_of_the_last_digit_is_that_of_the_print():
    assert half_digit("  5.00000e-04") == pytest.approx(5e-10)
    assert half_digit("0,000977", ",") == pytest.approx(5e-7)
    assert half_digit("two") == 0.0


def test_a_reader_may_state_a_rate_alone_or_an_axis():
    alone = RawChannel("a", 0, 4, 4, "g", 100.0)
    stated = RawChannel("a", 0, 4, 4, "g", axes=(TimeAxis("head", step=10.0, unit="ms"),))
    from shakerproc.recordings.timing import with_time_bases

    for channel in (alone, stated):
        made = with_time_bases(RawFile((RawGroup("", (channel,)),), None), Sampling())
        assert made.groups[0].channels[0].sample_rate == 100.0


@pytest.mark.shared
def test_channels_that_begin_apart_stand_beside_each_other(shared):
    """ch1 is twice the control, and begins 8 samples later in the file."""
    path = shared / "cases" / "07-tdms-starts" / "one_ms.tdms"
    with open_recording(path) as recording:
        control, ch1 = recording.samples()
        assert_allclose(ch1, 2.0 * control, rtol=1e-12, atol=1e-12)


@pytest.mark.shared
def test_contents_tell_what_a_spectrum_is(shared):
    path = shared / "cases" / "08-abscissa-not-seconds" / "spectrum2.tdms"
    groups, _ = contents(path)
    assert all("spectrum" in channel.problem for channel in groups[0].channels)
