"""Whatever the layout of a TDMS file, samples equal npTDMS' and slices equal the whole."""

import io

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nptdms import TdmsFile
from numpy.testing import assert_allclose, assert_array_equal
from tests.recordings import tdms_bytes
from tests.recordings.tdms_bytes import Builder

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.recordings import open_recording
from shakerproc.recordings.tdms import source
from shakerproc.recordings.tdms.reader import read_tdms

segments = st.tuples(
    st.integers(1, 40),  # values in a chunk
    st.integers(1, 4),  # chunks
    st.booleans(),  # interleaved
    st.booleans(),  # big endian
    st.sampled_from(["full", "list", "same", "none"]),
    st.sampled_from([0, 5]),  # padding
)
number_types = st.lists(
    st.sampled_from(["i1", "i2", "i4", "i8", "u1", "u2", "u4", "f4", "f8"]),
    min_size=1,
    max_size=4,
)


def built(dtypes, parts, seed):
    builder = Builder(dtypes)
    rng = np.random.default_rng(seed)
    before = (0, False)
    for part in parts:
        count, n_chunks, interleaved, big, wanted, padding = part
        meta = wanted if builder.starts else "full"
        values = before[0] if meta in {"same", "none"} else count
        bare = meta == "none"
        swapped = before[1] if bare else big
        builder.add(
            rng,
            values,
            n_chunks,
            interleaved=interleaved,
            big=swapped,
            meta=meta,
            padding=0 if bare else padding,
        )
        before = (values, swapped)
    return builder


@settings(
    max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    dtypes=number_types,
    parts=st.lists(segments, min_size=1, max_size=5),
    seed=st.integers(0, 2**32 - 1),
    cuts=st.tuples(st.floats(0, 1), st.floats(0, 1)),
    batch=st.sampled_from([16, 64, 1 << 20]),
)
def test_any_slice_of_any_layout_equals_nptdms(tmp_path, dtypes, parts, seed, cuts, batch):
    builder = built(dtypes, parts, seed)
    path = tmp_path / "random.tdms"
    path.write_bytes(builder.content)
    oracle = TdmsFile.read(io.BytesIO(builder.content))
    expected = np.array([c[:].astype(float) for c in oracle["All Data"].channels()])
    assert_array_equal(expected, builder.rows())  # the oracle is believed twice
    n = expected.shape[1]
    start, stop = sorted(round(cut * n) for cut in cuts)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(source, "BATCH", batch)
        with open_recording(path) as recording:
            samples = recording.samples(start, stop)
            blocks = np.concatenate(list(recording.blocks(size=3)), axis=1)
            rows = recording.select([len(dtypes) - 1]).samples(start, stop)
    assert recording.n_samples == n
    assert recording.sample_rate == 1000.0
    assert not recording.incomplete
    assert_array_equal(samples, expected[:, start:stop] * STANDARD_GRAVITY)
    assert_array_equal(blocks, expected * STANDARD_GRAVITY)
    assert_array_equal(rows[0], expected[-1, start:stop] * STANDARD_GRAVITY)


@pytest.mark.parametrize("batch", [16, 1 << 20])
def test_channels_of_different_pace_are_each_read_whole(tmp_path, monkeypatch, batch):
    monkeypatch.setattr(source, "BATCH", batch)
    rng = np.random.default_rng(2)
    fast, slow = rng.standard_normal((3, 8)), rng.standard_normal((3, 2))
    objects = [
        tdms_bytes.listed("/'g'/'fast'", tdms_bytes.index("f8", 8)),
        tdms_bytes.listed("/'g'/'slow'", tdms_bytes.index("f8", 2)),
    ]
    raw = b"".join(f.tobytes() + s.tobytes() for f, s in zip(fast, slow, strict=True))
    path = tmp_path / "paces.tdms"
    path.write_bytes(tdms_bytes.segment(tdms_bytes.metadata(objects), raw, 2 + 4 + 8))
    file = read_tdms(path, "paces")
    assert [c.n_samples for c in file.groups[0].channels] == [24, 6]
    assert_array_equal(file.source.read([0], 3, 20)[0], fast.reshape(-1)[3:20])
    assert_array_equal(file.source.read([1], 1, 6)[0], slow.reshape(-1)[1:6])
    assert_array_equal(file.source.read([0, 1], 0, 6)[1], slow.reshape(-1))
    file.source.close()


@pytest.mark.parametrize("batch", [16, 1 << 20])
@pytest.mark.parametrize("n_channels", [1, 3])
def test_daqmx_integers_are_scaled(tmp_path, monkeypatch, batch, n_channels):
    monkeypatch.setattr(source, "BATCH", batch)
    content, expected = tdms_bytes.daqmx_file(np.random.default_rng(3), n_channels)
    path = tmp_path / "daqmx.tdms"
    path.write_bytes(content)
    oracle = TdmsFile.read(io.BytesIO(content))
    with open_recording(path) as recording:
        samples = recording.samples(7, 93)
        assert [c.unit for c in recording.channels] == ["V"] * n_channels
    assert_allclose(samples, expected[:, 7:93], rtol=1e-15)
    for row, channel in zip(samples, oracle["g"].channels(), strict=True):
        assert_array_equal(row, channel[7:93])


def test_daqmx_in_two_buffers(tmp_path):
    """Two cards: each has rows of its own, one after the other in a chunk."""
    rng = np.random.default_rng(4)
    one = rng.integers(-9, 9, (5, 2)).astype("<i2")
    two = rng.integers(-9, 9, (3, 1)).astype("<i4")
    scales = {"NI_Number_Of_Scales": 1, "wf_increment": 0.5}
    objects = [
        tdms_bytes.listed(
            f"/'g'/'a{i}'", tdms_bytes.daqmx_index([("i2", 0, 2 * i, 0)], 5, [4, 4]), scales
        )
        for i in range(2)
    ]
    objects.append(
        tdms_bytes.listed(
            "/'g'/'b'", tdms_bytes.daqmx_index([("i4", 1, 0, 0)], 3, [4, 4]), scales
        )
    )
    content = tdms_bytes.segment(
        tdms_bytes.metadata(objects), (one.tobytes() + two.tobytes()) * 2, 2 + 4 + 8 + 128
    )
    path = tmp_path / "two.tdms"
    path.write_bytes(content)
    oracle = TdmsFile.read(io.BytesIO(content))
    file = read_tdms(path, "two")
    for channel in file.groups[0].channels:
        assert_array_equal(
            file.source.read([channel.row], 0, channel.n_samples)[0],
            oracle["g"][channel.name][:].astype(float),
        )
    file.source.close()


def test_a_polynomial_scale_is_that_of_nptdms(tmp_path):
    extra = {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Polynomial",
        "NI_Scale[0]_Polynomial_Coefficients_Size": 3,
        "NI_Scale[0]_Polynomial_Coefficients[0]": 1.0,
        "NI_Scale[0]_Polynomial_Coefficients[1]": -2.0,
        "NI_Scale[0]_Polynomial_Coefficients[2]": 0.5,
        "NI_Scale[0]_Polynomial_Input_Source": 0xFFFFFFFF,
    }
    builder = Builder(["i2"], extra=extra, unit="m/s^2").add(np.random.default_rng(5), 40)
    path = tmp_path / "poly.tdms"
    path.write_bytes(builder.content)
    raw = builder.rows()[0]
    with open_recording(path) as recording:
        assert_allclose(recording.samples()[0], 1.0 - 2.0 * raw + 0.5 * raw**2, rtol=1e-12)
