"""No path of a log leads out of its folder, whatever system it was meant for."""

import os
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shakerproc.errors import DocumentError, LogError
from shakerproc.testlog import read_testlog
from shakerproc.testlog.fields import Below, is_inside, relative_path

ATTACKS = [
    "../secret.tdms",
    "a/../../secret.tdms",
    "..",
    "a/..",
    "..\\secret.tdms",
    "a\\..\\..\\secret.tdms",
    "/etc/passwd",
    "//server/share/a.tdms",
    "\\\\server\\share\\a.tdms",
    "\\\\?\\C:\\a.tdms",
    "\\\\.\\PhysicalDrive0",
    "C:\\Users\\a.tdms",
    "C:/Users/a.tdms",
    "C:a.tdms",
    "c:",
    "a.tdms:stream",
    "file:///etc/passwd",
    "http://example.org/a.tdms",
    "con",
    "CON.tdms",
    "nul",
    "NUL.tdms.txt",
    "a/aux/b.tdms",
    "prn.tdms",
    "com1.tdms",
    "COM9",
    "lpt1",
    "com¹.tdms",
    "conin$",
    "CLOCK$",
    "~/a.tdms",
    "~root/a.tdms",
    "a.tdms.",
    "a.tdms ",
    " a.tdms",
    "a./b.tdms",
    "a /b.tdms",
    "nul /a.tdms",
    "nul .tdms",
    "a\x00b.tdms",
    "a\nb.tdms",
    "a\x1b[31m.tdms",
    "a\u202eb.tdms",
    "*.tdms",
    "a?.tdms",
    "a|b.tdms",
    "a>b.tdms",
    'a"b.tdms',
    "",
    " ",
    "a" * 600,
]


@pytest.mark.parametrize("text", ATTACKS)
def test_an_attack_is_refused(text):
    with pytest.raises(ValueError, match="expected a path below the folder") as caught:
        relative_path(text)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("Test_1/Acceleration.tdms", "Test_1/Acceleration.tdms"),
        ("Test_1\\Acceleration.tdms", "Test_1/Acceleration.tdms"),
        ("a.b/c..d.tdms", "a.b/c..d.tdms"),
        ("console.tdms", "console.tdms"),
        ("com10.tdms", "com10.tdms"),
        ("Prüfung 3/Beschleunigung.tdms", "Prüfung 3/Beschleunigung.tdms"),
        (".", "."),
        ("./a.tdms", "./a.tdms"),
        ("=a@b,c(1)+'~'.tdms", "=a@b,c(1)+'~'.tdms"),
    ],
)
def test_an_honest_path_is_taken(text, path):
    assert relative_path(text) == path


@given(st.text("ab./\\:~ CONnul*\x00", max_size=20))
def test_whatever_is_taken_stays_below(tmp_path_factory, text):
    folder = tmp_path_factory.getbasetemp()
    try:
        path = Below(folder).path(text)
    except ValueError:
        path = folder / "inside"
    assert os.path.normpath(path).startswith(str(folder))
    assert is_inside(path, folder)


LOG = "testlog: 1\ntests:\n  - {id: 1, recording: a.tdms}\n  - {id: 2, recording: b/c.tdms}\n"

needs_links = pytest.mark.skipif(sys.platform == "win32", reason="links need rights on Windows")


@pytest.fixture
def campaign(tmp_path):
    folder = tmp_path / "campaign"
    (folder / "recordings" / "b").mkdir(parents=True)
    (folder / "testlog.yaml").write_text(LOG)
    (folder / "recordings" / "a.tdms").write_bytes(b"a")
    (folder / "recordings" / "b" / "c.tdms").write_bytes(b"c")
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "c.tdms").write_bytes(b"secret")
    return folder


def test_recordings_that_are_there_are_found(campaign):
    log = read_testlog(campaign / "testlog.yaml", strict=True)
    assert [t.require_recording().read_bytes() for t in log.tests] == [b"a", b"c"]
    assert all(t.recording.is_absolute() for t in log.tests)


@needs_links
@pytest.mark.parametrize("target", ["../../outside/c.tdms", "/etc/passwd"])
def test_a_recording_that_links_outside_is_refused(campaign, target):
    (campaign / "recordings" / "a.tdms").unlink()
    (campaign / "recordings" / "a.tdms").symlink_to(target)
    with pytest.raises(DocumentError, match=r":3:24: tests\.1\.recording: .* leads outside"):
        read_testlog(campaign / "testlog.yaml")


@needs_links
def test_a_folder_that_links_outside_is_refused(campaign):
    (campaign / "recordings" / "b" / "c.tdms").unlink()
    (campaign / "recordings" / "b").rmdir()
    (campaign / "recordings" / "b").symlink_to("../../outside")
    with pytest.raises(DocumentError, match=r":4:24: tests\.2\.recording: .* leads outside"):
        read_testlog(campaign / "testlog.yaml")


@needs_links
def test_recordings_themselves_may_not_be_a_link_outside(campaign):
    (campaign / "recordings").rename(campaign.parent / "elsewhere")
    (campaign / "recordings").symlink_to("../elsewhere")
    (campaign / "testlog.yaml").write_text(
        LOG.replace("tests:", "recordings: recordings\ntests:")
    )
    with pytest.raises(DocumentError, match=r":2:13: recordings: .* leads outside"):
        read_testlog(campaign / "testlog.yaml")


@needs_links
def test_a_link_that_stays_inside_is_followed(campaign):
    (campaign / "recordings" / "a.tdms").unlink()
    (campaign / "recordings" / "a.tdms").symlink_to("b/c.tdms")
    log = read_testlog(campaign / "testlog.yaml")
    assert log.tests[0].require_recording().read_bytes() == b"c"


@needs_links
def test_a_loop_of_links_is_refused(campaign):
    (campaign / "recordings" / "a.tdms").unlink()
    (campaign / "recordings" / "a.tdms").symlink_to("a.tdms")
    with pytest.raises(DocumentError, match="leads outside"):
        read_testlog(campaign / "testlog.yaml")


@needs_links
def test_a_recording_that_became_a_link_since_is_refused(campaign):
    log = read_testlog(campaign / "testlog.yaml")
    (campaign / "recordings" / "a.tdms").unlink()
    (campaign / "recordings" / "a.tdms").symlink_to("../../outside/c.tdms")
    with pytest.raises(LogError, match=r"test 1: .* is a link to outside"):
        log.tests[0].require_recording()


def test_a_recording_named_in_another_case_is_told_as_it_is_named(campaign):
    there = campaign / "recordings" / "a.tdms"
    there.rename(there.with_name("A.TDMS"))
    log = read_testlog(campaign / "testlog.yaml")
    with pytest.raises(LogError, match=r'a\.tdms, did you mean "A\.TDMS"\?; put'):
        log.tests[0].require_recording()


def test_a_missing_recording_is_an_error_of_its_test_alone(campaign):
    (campaign / "recordings" / "a.tdms").unlink()
    log = read_testlog(campaign / "testlog.yaml")
    assert log.tests[1].require_recording().name == "c.tdms"
    with pytest.raises(LogError, match=r"testlog\.yaml:3: test 1: no recording .*a\.tdms"):
        log.tests[0].require_recording()


def test_a_missing_recording_is_told_where_that_is_asked(campaign):
    (campaign / "recordings" / "b" / "c.tdms").unlink()
    with pytest.raises(DocumentError, match=r":4:24: tests\.2\.recording: no recording"):
        read_testlog(campaign / "testlog.yaml", strict=True)


def test_a_test_without_a_recording_says_so(campaign):
    (campaign / "testlog.yaml").write_text("testlog: 1\ntests:\n  - {id: 7}\n")
    log = read_testlog(campaign / "testlog.yaml")
    with pytest.raises(LogError, match="test 7 has no recording; add the key"):
        log.tests[0].require_recording()


def test_a_folder_is_no_recording(campaign):
    (campaign / "testlog.yaml").write_text("testlog: 1\ntests:\n  - {id: 7, recording: b}\n")
    with pytest.raises(LogError, match="no recording"):
        read_testlog(campaign / "testlog.yaml").tests[0].require_recording()


@needs_links
@pytest.mark.parametrize("name", ["../specimens.yaml", "/etc/passwd", "link.yaml"])
def test_specimens_are_read_from_below_too(campaign, name):
    (campaign.parent / "specimens.yaml").write_text("specimens: 1\njoints: {}\n")
    (campaign / "link.yaml").symlink_to("../specimens.yaml")
    log = LOG.replace("tests:", f"specimens: {name}\ntests:")
    (campaign / "testlog.yaml").write_text(log)
    with pytest.raises(DocumentError, match=r":2:12: specimens: expected a path below"):
        read_testlog(campaign / "testlog.yaml")
