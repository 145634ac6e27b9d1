"""The manual: it builds strictly, needs nothing from elsewhere, and its commands run."""

import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from tests.docs import console
from tests.docs.fixtures import write_recordings
from tests.few_effects import seek_few
from tests.in_process import run

from shakerproc.report.evidence import comparison
from shakerproc.report.runs import drawing

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def script(name):
    """A script of docs/, which is no package."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


effect_pages, make_mimics = script("effect_pages"), script("make_mimics")
make_images = script("make_images")
TUTORIAL, COUPON = DOCS / "tutorial.md", DOCS / "thesis.md"
PAGES = sorted(p for p in DOCS.rglob("*.md") if "```console" in p.read_text(encoding="utf-8"))
DIAGNOSING = [p for p in PAGES if "\n$ shakerproc diagnose" in p.read_text(encoding="utf-8")]


def played(page, folder):
    """Run the commands of a page beside what they read; return what differs from the page."""
    for name in ("sample_data", "configs", "examples", "docs"):
        (folder / name).symlink_to(ROOT / name)
    write_recordings(folder)
    return console.play(page, folder)


def draw_only(patch, places):
    """Have runs and comparisons draw what is looked at later, and no more."""
    folders = {Path(place).parent.name for place in places}
    names = {Path(place).stem for place in places}
    draw, figures_of = drawing.draw_run, comparison.figures_of

    def drawn(result, title, where):
        return draw(result, title, where) if f"test_{result.test.id}" in folders else []

    def kept(found):
        return {name: one for name, one in figures_of(found).items() if name in names}

    patch.setattr(drawing, "draw_run", drawn)
    patch.setattr(comparison, "figures_of", kept)


@pytest.fixture(scope="module")
def tutorial(tmp_path_factory):
    """Where the commands of the tutorial were run, and what differs from the page."""
    folder = tmp_path_factory.mktemp("tutorial")
    with pytest.MonkeyPatch.context() as patch:
        seek_few(patch)
        draw_only(patch, make_images.TUTORIAL)
        return folder, played(TUTORIAL, folder)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if page not in {TUTORIAL, COUPON}],  # COUPON: test_coupon_command
    ids=lambda path: path.stem,
)
def test_every_command_of_a_page_prints_what_the_page_shows(
    page, tmp_path, few_effects, monkeypatch
):
    draw_only(monkeypatch, ())
    wrong = played(page, tmp_path)
    assert not wrong, "\n\n".join(wrong)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", DIAGNOSING, ids=lambda path: path.stem)
def test_pages_show_what_is_found_among_all_effects(page, tmp_path):
    wrong = played(page, tmp_path)
    assert not wrong, "\n\n".join(wrong)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_every_command_of_the_tutorial_prints_what_it_shows(tutorial):
    _, wrong = tutorial
    assert not wrong, "\n\n".join(wrong)


def test_the_comparison_of_outputs_finds_what_differs():
    assert console.disagreement(("a 1.00", "...", "b"), "a 1.01\nx\ny\nb\n") is None
    assert console.disagreement(("a 1.00",), "a 1.02\n") == "a 1.00"
    assert console.disagreement(("c 4.995e-05",), "c 4.97e-05\n") == "c 4.995e-05"
    assert console.disagreement(("a 1.2",), "a 1.3\n") is None
    assert console.disagreement(("a 1.2e-3",), "a 1.3e-3\n") is None
    assert console.disagreement(("a 1.2",), "a 1.4\n") == "a 1.2"
    assert console.disagreement(("12 tests",), "13 tests\n") == "12 tests"
    assert console.disagreement(("a", "b"), "a\nx\nb\n") == "b"
    assert "nothing more" in console.disagreement(("a",), "a\nb\n")
    assert console.disagreement(("gap 1",), "stop 1\n") == "gap 1"


def test_the_interval_in_the_text_is_the_one_that_is_printed():
    """README.md and the tutorial tell the clearance in words, with the digits of the table."""
    page = TUTORIAL.read_text(encoding="utf-8")
    row = re.search(r"^gap .* clearance +\S+ +(\S+) +(\S+) +m ", page, re.MULTILINE)
    low, high = (1e3 * float(text) for text in row.groups())
    for path, wanted in (
        (ROOT / "README.md", r"\(([\d.]+) to ([\d.]+) mm\)\. Added to the model"),
        (TUTORIAL, r"between ([\d.]+) and ([\d.]+) mm with 95 % confidence"),
    ):
        told = re.search(wanted, path.read_text(encoding="utf-8")).groups()
        shown = [
            f"{value:.{len(text.partition('.')[2])}f}"
            for value, text in zip((low, high), told, strict=True)
        ]
        assert list(told) == shown, path.name


def test_the_errors_of_readme_are_those_of_the_tutorial():
    """The demo goes through the tutorial's campaign, whose printed tables a test compares."""
    shown = r"^(\d)(?: \(held out\))? +\S+ g\^2/Hz +ch3 +(\S+) +(\S+) "
    rows = re.findall(shown, TUTORIAL.read_text(encoding="utf-8"), re.MULTILINE)
    before, after = rows[:4], rows[4:]
    told = re.findall(
        r"^    (\d) +\S+ g\^2/Hz +(?:yes +)?(\S+) +(\S+) +(\S+)$",
        (ROOT / "README.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert told == [
        (test, old, new, noise)
        for (test, old, _), (_, new, noise) in zip(before, after, strict=True)
    ]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocs", reason="the extra docs is not installed")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_the_manual_fetches_nothing_from_elsewhere(site):
    wanted = re.compile(
        r"""<(?:script|link|img|iframe|source)[^>]*(?:src|href)=["'](?:https?:)?//[^"']*"""
        r"""|url\(\s*["']?(?:https?:)?//|@import"""
    )
    for path in [*site.rglob("*.html"), *site.rglob("*.css")]:
        found = wanted.search(path.read_text(encoding="utf-8"))
        assert found is None, f"{path.relative_to(site)}: {found[0]}"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("chromium") is None, reason="no Chromium to search with")
def test_the_search_works_without_a_server(site):
    asked = f"{(site / 'search.html').as_uri()}?q=bristle"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000"]
    done = subprocess.run(
        ["chromium", *options, "--dump-dom", asked],
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert 'href="./effects/lugre_friction.html"' in done.stdout


@pytest.mark.slow
def test_there_is_a_page_with_a_picture_for_each_effect_and_fault(site):
    from shakerproc.models import EFFECTS, FAULTS

    for kind in (*EFFECTS, *FAULTS):
        page = (site / "effects" / f"{kind}.html").read_text(encoding="utf-8")
        assert f'src="{kind}.svg"' in page
        assert (site / "effects" / f"{kind}.svg").is_file()
        for heading in ("In the data", "What it is confused with", "In a model file"):
            assert heading in page
        if kind in EFFECTS:
            assert "<math" in page
            assert "\\" not in re.search("<math.*?</math>", page, re.DOTALL)[0]


def columns_named(page, heading):
    """Words in code marks of the tables of a section, by the file that their row names."""
    section = page.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    for line in section.splitlines():
        cells = line.split(" | ")  # of a paragraph there is one, whatever it names
        if len(cells) == 1:
            continue
        files = re.findall(r"`([\w/.*]+\.csv)`", cells[0])
        if files:
            words = re.findall(r"`([a-z0-9_]+)`", " ".join(cells[1:]))
            yield files[0].replace("test_ID", "test_*"), words


RICHER = [
    ("gap", "offset_gap"),
    ("stop", "offset_gap"),
    ("cubic_stiffness", "power_law"),
    ("coulomb_friction", "stribeck_friction"),
]


def test_an_effect_that_holds_another_as_a_special_case_passes_for_it_and_not_the_reverse():
    found = json.loads(make_mimics.FILE.read_text(encoding="utf-8"))
    for simple, rich in RICHER:
        for levels in make_mimics.LEVELS:
            assert found[simple][rich][levels] < 1e-3
            assert found[rich][simple][levels] > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("truth", "other"), [("gap", "power_law"), ("quadratic_stiffness", "stop")]
)
def test_the_table_of_what_passes_for_what_is_current(truth, other):
    found = json.loads(make_mimics.FILE.read_text(encoding="utf-8"))
    assert set(found) == set(make_mimics.EXAMPLES) - make_mimics.LEFT_OUT
    for name, levels in make_mimics.LEVELS.items():
        example = make_mimics.EXAMPLES
        share = make_mimics.mimicked(example[truth], example[other], levels)
        assert share == pytest.approx(found[truth][other][name], abs=2e-3)


@pytest.fixture(scope="module")
def worked(tutorial):
    """Where the tutorial and a batch of the sample data were processed, with pictures."""
    folder, _ = tutorial
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(make_images, "shakerproc", run)  # without the seconds of a start
        draw_only(patch, make_images.BATCH)
        make_images.sample(folder)
    make_images.pictures(folder, folder / "images")
    return folder


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("heading", "out"),
    [("Tables of a batch", "batch"), ("Tables of a comparison", "comparison")],
)
def test_the_columns_that_the_page_of_formats_names_are_written(heading, out, worked):
    rows = list(columns_named((DOCS / "formats.md").read_text(encoding="utf-8"), heading))
    assert len(rows) >= 3
    for name, wanted in rows:
        tables = list(worked.glob(f"{out}/{name}"))
        assert tables, name
        headers = [path.read_text("utf-8").partition("\n")[0] for path in tables]
        for word in wanted:
            assert any(word in header for header in headers), f"{name}: {word}"


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_pictures_kept_are_those_that_the_commands_draw(worked):
    """Not to the byte: another machine has other fonts."""
    import matplotlib.image
    import numpy as np

    drawn = sorted(worked.glob("images/*.png"))
    assert len(drawn) == 7
    for path in drawn:
        new, kept = (matplotlib.image.imread(p) for p in (path, DOCS / "images" / path.name))
        assert new.shape == kept.shape, f"{path.name}: run python docs/make_images.py"
        differs = np.mean(np.abs(new - kept).max(axis=-1) > 0.3)
        assert differs < 0.02, f"{path.name}: run python docs/make_images.py"


def test_the_model_on_the_page_of_formats_is_read(tmp_path):
    from shakerproc.model_files import read_model

    page = (DOCS / "formats.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```yaml\n(model: 1.*?)```", page, re.DOTALL)
    path = tmp_path / "model.yaml"
    path.write_text(block, encoding="utf-8")
    assert len(read_model(path).elements) == 3


def test_every_snippet_of_an_effect_is_read(tmp_path):
    """The line that a page shows, put into a whole model."""
    from shakerproc.model_files import read_model
    from shakerproc.models import EFFECTS, FAULTS

    pages = effect_pages.pages()
    assert set(pages) == {*EFFECTS, *FAULTS}
    frame = "model: 1\nmasses: {coupon: 28.6 g}\nexcitation: {base: acceleration}\n"
    spring = "  - {kind: spring, between: [base, coupon], stiffness: 1.2e5 N/m}\n"
    for kind in pages:
        line = effect_pages.snippet(kind) + "\n"
        text = line + "elements:\n" + spring if kind in FAULTS else line + spring
        path = tmp_path / f"{kind}.yaml"
        path.write_text(frame + text, encoding="utf-8")
        model = read_model(path)
        if kind in EFFECTS:
            assert [element.effect.kind for element in model.elements] == [kind, "spring"]
        else:
            assert [fault.kind for fault in model.sensors["ch3"].faults] == [kind]


def test_what_an_effect_is_confused_with_is_another_known_one():
    notes = yaml.safe_load(effect_pages.NOTES.read_text(encoding="utf-8"))
    assert set(notes) == set(effect_pages.pages())
    for kind, others in notes.items():
        assert others
        assert set(others) <= set(notes) - {kind}


def test_the_page_of_the_house_has_every_room_in_the_order_of_the_contract():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = contracts["tool"]["importlinter"]["contracts"][0]["layers"]
    wanted = [line.replace("|", " ").split() for line in layers if line != "__main__"]
    page = (DOCS / "architecture.md").read_text(encoding="utf-8")
    picture = page.split("```")[1].splitlines()[1:]
    names = {room for rooms in wanted for room in rooms}
    drawn = [[word for word in line.split() if word in names] for line in picture]
    assert [set(rooms) for rooms in drawn] == [set(rooms) for rooms in wanted]
    told = page.split("## The rooms")[1].split("## The way")[0]
    assert all(f"**{room}**" in told for room in names)


def test_the_drawing_of_the_rooms_is_that_of_the_imports():
    done = subprocess.run(
        [sys.executable, DOCS / "make_rooms_drawing.py", "--check"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_every_file_on_the_way_through_the_house_is_there():
    page = (DOCS / "architecture.md").read_text(encoding="utf-8").split("## The way", 1)[1]
    files = {word for word in re.findall(r"`([a-z_/]+\.py)`", page) if "/" in word}
    assert files
    house = ROOT / "src" / "shakerproc"
    missing = [f for f in files if not any(house.rglob(f))]
    assert not missing
