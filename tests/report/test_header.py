"""The head of the report for a customer: what the log says, inert, the photo encoded anew."""

import base64
import io
import re

import pytest
from PIL import Image
from tests.small_campaign import write_campaign

from shakerproc.errors import DocumentError, LogError
from shakerproc.report.page.page import Report, html
from shakerproc.report.page.sections import header_view, photo_uri
from shakerproc.testlog import read_testlog

HEAD = """\
report:
  client: "<script>alert(1)</script> Ltd"
  order: 4711
  specimen: bracket
  photo: photo.jpg
  instruments:
    - {instrument: shaker, serial: 12, calibrated: 2026-03-31}
    - {instrument: amplifier}
"""


def log_with(folder, head):
    path = write_campaign(folder, 1)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("channels:", head + "channels:", 1), encoding="utf-8")
    return path


def write_photo(path, size=(1600, 800), **more):
    Image.new("RGB", size, (200, 30, 30)).save(path, **more)


def test_what_the_log_says_is_shown_and_nothing_else(tmp_path):
    write_photo(tmp_path / "photo.jpg")
    view = header_view(read_testlog(log_with(tmp_path, HEAD)))
    assert [label for label, _ in view.lines] == ["client", "order", "specimen"]
    assert list(view.instruments.columns) == ["instrument", "serial number", "calibrated"]
    assert list(view.instruments.rows[1]) == ["amplifier", "", ""]
    text = html(Report("A", [], header=view))
    assert "&lt;script&gt;alert(1)&lt;/script&gt; Ltd" in text
    assert text.count("<script>") == 1
    assert "img-src data:" in text
    assert "operator" not in text[text.index("<main>") : text.index('id="methods"')]
    assert header_view(read_testlog(write_campaign(tmp_path / "plain", 1))) is None


def test_the_photo_is_upright_smaller_and_without_metadata(tmp_path):
    exif = Image.Exif()
    exif[0x0112] = 6  # turned by a quarter
    exif[0x010E] = "a secret"
    write_photo(tmp_path / "photo.jpg", exif=exif)
    head, content = photo_uri(tmp_path / "photo.jpg").split(",")
    assert head == "data:image/jpeg;base64"
    encoded = base64.b64decode(content)
    assert b"secret" not in encoded
    with Image.open(io.BytesIO(encoded)) as picture:
        assert picture.size == (600, 1200)
        assert picture.getpixel((300, 600)) == pytest.approx((200, 30, 30), abs=6)
    glass = Image.new("RGBA", (40, 20), (0, 0, 0, 0))  # transparent becomes white, not black
    glass.save(tmp_path / "glass.png")
    content = photo_uri(tmp_path / "glass.png").split(",")[1]
    with Image.open(io.BytesIO(base64.b64decode(content))) as picture:
        assert min(picture.getpixel((5, 5))) > 250


@pytest.mark.parametrize(
    ("photo", "message"),
    [
        ("absent.jpg", r":5:10: report.photo: no file .*absent.jpg; put the photo there"),
        ("../photo.jpg", r":5:10: report.photo: expected a path below the folder"),
        ("large.jpg", r":5:10: report.photo: expected a photo of at most 20 MB, large.jpg has"),
    ],
)
def test_a_photo_that_cannot_be_taken_is_an_error_of_the_log(tmp_path, photo, message):
    folder = tmp_path / "log"
    folder.mkdir()
    write_photo(tmp_path / "photo.jpg")
    (folder / "large.jpg").write_bytes(bytes(20_000_001))
    path = log_with(folder, f"report:\n  photo: {photo}\n")
    with pytest.raises(DocumentError, match=message) as caught:
        read_testlog(path)
    assert "\n" not in str(caught.value)


def test_what_is_no_picture_is_told_in_one_line(tmp_path):
    bomb = tmp_path / "bomb.png"
    Image.new("1", (12_000, 12_000)).save(bomb)
    with pytest.raises(LogError, match="the photo has more than 89 million pixels"):
        photo_uri(bomb)
    (tmp_path / "text.jpg").write_text("<svg onload=alert(1)>", encoding="utf-8")
    with pytest.raises(LogError, match="no photo that can be read; save it as one of JPEG"):
        photo_uri(tmp_path / "text.jpg")
    write_photo(tmp_path / "cut.jpg", size=(300, 300))
    whole = (tmp_path / "cut.jpg").read_bytes()
    (tmp_path / "cut.jpg").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(LogError, match="no photo that can be read") as caught:
        photo_uri(tmp_path / "cut.jpg")
    assert "\n" not in str(caught.value)


def test_a_day_that_is_none_is_an_error_of_the_log(tmp_path):
    head = "report:\n  instruments: [{instrument: shaker, calibrated: soon}]\n"
    with pytest.raises(DocumentError, match=r"expected a day such as 2026-03-31, got .?soon"):
        read_testlog(log_with(tmp_path, head))
    head = head.replace("soon", "2026-03-31, valid_until: 2025-03-31")
    with pytest.raises(DocumentError, match=r"valid_until: expected a day after 2026-03-31"):
        read_testlog(log_with(tmp_path, head))


def test_pages_are_numbered_and_contents_lead_to_what_is_there(tmp_path):
    text = html(Report("A", []))
    assert "counter(page)" in text
    contents = re.search(r'<section class="contents".*?</section>', text, re.DOTALL)[0]
    links = re.findall(r'href="#([^"]+)"', contents)
    assert links
    assert all(f'id="{link}"' in text for link in links)
