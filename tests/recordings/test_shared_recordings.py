"""Recordings that others measured and published: each is read, or refused in one line."""

import re

import numpy as np
import pytest
from nptdms import TdmsFile
from numpy.testing import assert_allclose, assert_array_equal
from tests.recordings.shared_data import outcome

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import FilePart, health, open_recording
from shakerproc.recordings.tdms.reader import read_tdms

pytestmark = pytest.mark.shared

LVM = "no sample rate .* the file contradicts itself: .*165[23].* Hz .*1706.48 Hz"
NO_RATE = "the file does not say the sample rate"
NO_UNIT = "wf_increment, 1 as LabVIEW writes it where none is given, states no unit"
MOVELLA = ("no sample rate for channel 'Euler_X'", {"sample_rate": 120.0}, (9, 120.0))
GROUPS = "groups hold data"
LENGTHS = "Use only channels of one length"
MOVELLA_FILES = (
    "GroundFloor__(El Centro Trial 1) left leg_20250402_171355",
    "GroundFloor__(Northridge Trial 1) left leg_20250402_171541",
    "TopFloor__(El Centro Trial 1) left thigh_20250402_171355",
    "TopFloor__(Northridge Trial 1) left thigh_20250402_171541",
)

# (channels, rate [Hz]) of the file as it is; or the refusal; or the refusal, what helps, and
# what comes then
EXPECTED = {
    **{f"mini_shaketable_brace2/stiff1_{name}.csv": MOVELLA for name in MOVELLA_FILES},
    "bobcat_analyzer_vibrationtesting/case1.mat": (2, 1280.0),
    "bobcat_analyzer_vibrationtesting/case2.mat": (2, 1280.0),
    "cued_gc4/tf_data.npz": "'f' is no channel: it advances evenly",
    "cued_gc4/time_data.npz": (5, 1000.0),
    "friction_backlash_arts/ds1_0.5Hz70lbtension.json": "no reader for .json",
    "friction_backlash_arts/ds1_1Hz20lbtension.json": "no reader for .json",
    "friction_backlash_arts/ds1_1Hz70lbtension.json": "no reader for .json",
    "friction_backlash_arts/ds1_1Hz80lbtension.json": "no reader for .json",
    "friction_backlash_arts/LICENSE.txt": "no table of numbers",
    "shaker_pcb_lvm_dataset7/amplitude_1_Impact_0.0_vibration_0.5.lvm": LVM,
    "shaker_pcb_lvm_dataset7/amplitude_1_Impact_1_vibration_0.0.lvm": LVM,
    "shaker_pcb_lvm_dataset7/amplitude_5_Impact_0.0_vibration_0.5.lvm": LVM,
    "shaker_pcb_lvm_dataset7/amplitude_5_Impact_0.0_vibration_1.lvm": LVM,
    "shaker_pcb_lvm_dataset7/amplitude_5_Impact_0.5_vibration_0.5.lvm": LVM,
    "shaketable_thadhaines/MatLAB test data01_20190329_14-58-13.csv": (32, 1000.0),
    "shaketable_thadhaines/MatLAB_01_20190226_10-24-18.csv": (32, 1000.0),
    "silverbox/SNLS80mV.mat": (NO_RATE, {"sample_rate": 610.35}, (2, 610.35)),
    "tdms_crtomirjuren/DAQ-sim.tdms": (3, 100.0),
    "tdms_crtomirjuren/test_4_DUT_18.tdms": (3, 100.0),
    "tdms_danberge_jl/DAQmx example.tdms": "byte 232: the name of a property takes 19",
    "tdms_danberge_jl/incremental_test_1.tdms": (NO_RATE, {"sample_rate": 1.0}, (2, 1.0)),
    "tdms_danberge_jl/incremental_test_2.tdms": (NO_RATE, {"sample_rate": 1.0}, (2, 1.0)),
    "tdms_danberge_jl/incremental_test_3.tdms": (NO_RATE, {"sample_rate": 1.0}, (2, 1.0)),
    "tdms_danberge_jl/incremental_test_4.tdms": NO_RATE,
    "tdms_danberge_jl/incremental_test_5.tdms": NO_RATE,
    "tdms_danberge_jl/incremental_test_6.tdms": NO_RATE,
    "tdms_danberge_jl/reference_file.tdms": "holds no samples .*stops at byte 135",
    "tdms_mikeobrien/AdditionalProperties.tdms": NO_UNIT,
    "tdms_mikeobrien/IncrementalMetaInformation.tdms": NO_RATE,
    "tdms_mikeobrien/IncrementalMetaInformationInterleavedData.tdms": "'Time' states no unit",
    "tdms_mikeobrien/PropertyRewritten.tdms": NO_UNIT,
    "tdms_ni_parser/basic.tdms": (NO_UNIT, {"sample_rate": 1.0}, (4, 1.0)),
    "tdms_ni_parser/multiple_groups.tdms": (
        GROUPS,
        {"part": FilePart("Noise Tolerance")},
        (3, 100.0),
    ),
    "tdms_ni_parser/strings.tdms": (
        GROUPS,
        {"part": FilePart("test1"), "sample_rate": 1.0},
        (14, 1.0),
    ),
    "tdms_ni_parser/version1.tdms": (NO_RATE, {"sample_rate": 1.0}, (6, 1.0)),
    "tdms_nptdms/big_endian.tdms": (2, 1000.0),
    "tdms_nptdms/Digital_Input.tdms": (1, 2000.0),
    "tdms_nptdms/raw1.tdms": (7, 50000.0),
    "tdms_nptdms/raw_timestamps.tdms": (1, 1000.0),
    "tdms_owilab/faulty_tdms_01.tdms": "byte 21123: a segment should begin here with b'TDSm'",
    "tdms_owilab/good_tdms_1.tdms": (8, 30.0),
    "tdms_owilab/good_tdms_2.tdms": (GROUPS, {"part": FilePart("acceleration")}, (8, 250.0)),
    "tdms_readTDMS_accel/MC_Off_1_Acc.tdms": (1, 10000.0),
    "tdms_totonga/example.tdms": (
        GROUPS,
        {"part": FilePart("M001A"), "sample_rate": 1.0},
        (3, 1.0),
    ),
    "uff_pyuff/MPSTD#Set001_2024_10_08_10_27_07.uff": (4, 3200.0),
    "uff_pyuff/Sample_UFF58_ascii.uff": (1, 65536.0),
    "uff_pyuff/Sample_UFF58b_bin.uff": (1, 65536.0),
    "uff_pyuff/sample_dataset58_psd.uff": "no time record",
}


def refusal(path, **options):
    with pytest.raises(RecordingError) as caught, open_recording(path, **options):
        pass
    message = str(caught.value)
    assert message.startswith(path.name)
    assert message.isprintable()
    assert len(message) < 600
    return message


def accepted(path, n_channels, rate, **options):
    with open_recording(path, **options) as recording:
        assert (len(recording.channels), recording.sample_rate) == (n_channels, rate)
        assert not recording.incomplete
        samples = recording.samples()
        assert samples.shape == (n_channels, recording.n_samples)
        if not any("not a number" in flag.kind for flag in health(recording)):
            assert np.all(np.isfinite(samples))


@pytest.mark.parametrize("name", EXPECTED)
def test_every_file_is_read_or_refused_in_one_line(shared, name):
    path, expected = shared / "data" / name, EXPECTED[name]
    if isinstance(expected, str):
        assert re.search(expected, refusal(path))
    elif isinstance(expected[0], str):
        match, options, then = expected
        assert re.search(match, refusal(path))
        accepted(path, *then, **options)
    else:
        accepted(path, *expected)


def test_every_file_beside_the_table_is_read_or_refused_in_one_line(shared):
    folder = shared / "data"
    files = {p.relative_to(folder).as_posix(): p for p in folder.glob("*/*") if p.is_file()}
    assert set(EXPECTED) <= set(files)
    told = {name: outcome(files[name]) for name in set(files) - set(EXPECTED)}
    refused = {name: text for name, text in told.items() if not text.startswith("read: ")}
    for name, text in refused.items():
        assert text.startswith(f"refused: {files[name].name}: ")
        assert text.isprintable()


@pytest.mark.parametrize(
    "name", [n for n in EXPECTED if n.endswith(".tdms") and "reference_file" not in n]
)
def test_the_numbers_are_those_of_nptdms(shared, name):
    path = shared / "data" / name
    try:
        oracle = TdmsFile.read(path)
    except Exception:  # noqa: BLE001  it raises whatever it likes
        pytest.skip("npTDMS cannot read it either")
    file = read_tdms(path, path.name)
    compared = 0
    for group in file.groups:
        for channel in group.channels:
            expected = oracle[group.name][channel.name]
            assert channel.n_samples == channel.promised == len(expected)
            if not channel.problem:
                found = file.source.read([channel.row], 0, channel.n_samples)
                assert_array_equal(found[0], expected[:].astype(float))
                compared += 1
    file.source.close()
    assert compared


def test_signalexpress_serves_all_data_and_never_the_decimated_copies(shared):
    path = shared / "data" / "tdms_nptdms" / "Digital_Input.tdms"
    oracle = TdmsFile.read(path)
    (whole,) = [g for g in oracle.groups() if g.name.endswith("All Data")]
    with open_recording(path) as recording:
        assert (recording.n_samples, recording.sample_rate) == (20_000, 2000.0)
        assert_array_equal(recording.samples()[0], whole.channels()[0][:].astype(float))
    with open_recording(path, part=FilePart(oracle.groups()[1].name)) as copy:
        assert (copy.n_samples, copy.sample_rate) == (400, 40.0)


def test_the_tower_is_read_in_g(shared):
    path = shared / "data" / "tdms_owilab" / "good_tdms_1.tdms"
    oracle = TdmsFile.read(path)["acceleration"]
    with open_recording(path) as recording:
        assert {c.unit for c in recording.channels} == {"m/s^2"}
        assert {c.source_unit for c in recording.channels} == {"g"}
        for row, channel in zip(recording.samples(), recording.channels, strict=True):
            expected = oracle[channel.source_name][:].astype(float) * STANDARD_GRAVITY
            assert_array_equal(row, expected)


def test_the_names_of_the_log_choose_the_group(shared):
    path = shared / "data" / "tdms_owilab" / "good_tdms_2.tdms"
    uses = [ChannelUse("SCB_ALM_RS_ACC_HOR012_X_nr1", "control")]
    with open_recording(path, uses=uses) as recording:
        assert (recording.sample_rate, recording.n_samples) == (250.0, 15_000)
    message = refusal(path)
    assert "'acceleration' (8 channels at 250 Hz); 'ambient' (16 channels)" in message


def test_a_real_accelerometer_is_scaled_as_nptdms_does_and_wants_its_sensitivity(shared):
    path = shared / "data" / "tdms_readTDMS_accel" / "MC_Off_1_Acc.tdms"
    volts = TdmsFile.read(path)["Acc"]["cDAQ1Mod2/ai0"][:]
    with open_recording(path) as recording:
        assert recording.channels[0].unit == "V"
        assert_array_equal(recording.samples(1000, 60_000)[0], volts[1000:60_000])
    use = ChannelUse("cDAQ1Mod2/ai0", "response")
    assert "sensitivity: 100 mV/g" in refusal(path, uses=[use])
    use = ChannelUse("cDAQ1Mod2/ai0", "response", sensitivity="100 mV/g")
    with open_recording(path, uses=[use]) as recording:
        expected = volts / 0.1 * STANDARD_GRAVITY
        assert_allclose(recording.samples()[0], expected, rtol=1e-12)


def test_the_refusal_of_the_dirty_file_tells_the_log_entry_that_makes_it_work(shared):
    folder = shared / "data" / "shaker_pcb_lvm_dataset7"
    path = folder / "amplitude_1_Impact_0.0_vibration_0.5.lvm"
    names = ["accelerometer_base", "accelerometer_board"]
    uses = [ChannelUse(names[0], "control"), ChannelUse(names[1], "response")]
    rate = re.search(r"processing: \{sample_rate: (.*?) Hz\}", refusal(path, uses=uses))
    assert rate is not None
    options = {"sample_rate": float(rate[1])}
    wanted = r"(\w+): \{role: control, unit: g, override: true\}"  # the file says seconds
    unit = re.search(wanted, refusal(path, uses=uses, **options))
    assert unit is not None
    assert unit[1] == "accelerometer_base"
    uses = [ChannelUse(use.key, use.role, unit="g", override=True) for use in uses]
    with open_recording(path, uses=uses, **options) as recording:
        assert (recording.n_samples, recording.sample_rate) == (12_375, float(rate[1]))
        assert any("the log is followed" in note for note in recording.notes)
        assert_allclose(recording.samples(0, 1)[:, 0] / STANDARD_GRAVITY, [0.048066, -0.026492])


def test_silverbox_works_with_the_rate_and_units_of_the_log(shared):
    path = shared / "data" / "silverbox" / "SNLS80mV.mat"
    uses = [ChannelUse("V1", "force", unit="N"), ChannelUse("V2", "displacement", unit="m")]
    assert "processing: {sample_rate:" in refusal(path, uses=uses)
    with open_recording(path, uses=uses, sample_rate=610.35) as recording:
        assert recording.n_samples == 131_072
        assert [c.unit for c in recording.channels] == ["N", "m"]


def test_the_text_and_the_binary_of_one_sound_agree(shared):
    folder = shared / "data" / "uff_pyuff"
    with (
        open_recording(folder / "Sample_UFF58_ascii.uff") as text,
        open_recording(folder / "Sample_UFF58b_bin.uff") as binary,
    ):
        assert_allclose(text.samples(), binary.samples(), rtol=1e-5)  # six digits in the text


def test_the_reference_recordings_are_five_channels_in_g(shared):
    for name in ("random_gap_5ch", "sweep_gap_5g_5ch"):
        with open_recording(shared / "reference" / "recordings" / f"{name}.tdms") as recording:
            assert len(recording.channels) == 5
            assert {c.source_unit for c in recording.channels} == {"g"}
            assert recording.sample_rate == pytest.approx(5688.89, rel=1e-5)
