"""Effects sought and added as a notebook does, by `import shakerproc`."""

from pathlib import Path

import pytest
from matplotlib.figure import Figure
from tests.comparison.small_campaigns import campaign, drive, written
from tests.few_effects import seek_few

import shakerproc as sp


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    drives = (drive(level=3.0), drive(level=5.0, number=2))
    folder = tmp_path_factory.mktemp("campaign")
    return written(campaign(drives=drives, seconds=1.2), folder)


@pytest.fixture(scope="module")
def given(files):
    log, model = files
    return sp.read_model(model), sp.read_log(log)


@pytest.mark.slow
def test_an_effect_is_added_twice_and_saved_once_it_is_asked(
    files, given, tmp_path, fitted_once
):
    model, log = given
    before = Path(files[1]).read_bytes()
    with pytest.raises(sp.ShakerprocError, match="gap between base and coupon: the held-out"):
        sp.add("gap", model, log)
    found = sp.add("gap", model, log, force=True, between=["base", "coupon"])
    saved = found.save(tmp_path / "new.yaml")
    assert Path(files[1]).read_bytes() == before
    again = sp.read_model(saved).model
    assert again.elements == found.model.elements
    assert again.title == found.title
    assert set(found.intervals["of"]) == {"gap", "model"}
    held_out = found.errors.held_out
    assert held_out.before == pytest.approx(held_out.after, rel=5e-2)
    for one, said in ((model, held_out.before), (sp.read_model(saved), held_out.after)):
        assert sp.compare(one, log).held_out_error == pytest.approx(said, rel=1e-9)
    assert len(found.to_pandas()) == 3
    assert "<p>the held-out error " in found._repr_html_()
    assert isinstance(found.plot(), Figure)
    with pytest.raises(sp.ArgumentError, match="NEW must be another file"):
        found.save(files[1])
    made = sp.add("gap", model.model, log, force=True).save(tmp_path / "made.yaml")
    assert sp.read_model(made).model.title == found.title


@pytest.mark.slow
def test_a_complete_model_is_told_to_be_complete_twice(given, monkeypatch):
    seek_few(monkeypatch, {"gap", "cubic_stiffness"})
    found, again = sp.diagnose(*given), sp.diagnose(*given)
    assert found.verdict == again.verdict == "nothing missing"
    assert found.as_json() == again.as_json()
    said = found.as_json()["errors"]["held_out"]["before"]
    assert sp.compare(*given).held_out_error == pytest.approx(said, rel=1e-9)
    for one in found.as_json()["candidates"]:  # each has a number
        assert (one["held_out_error"] is None) != (one["screened"] is None)
    assert isinstance(found.plot(), Figure)
    assert "Nothing is missing" in found._repr_html_()
    assert len(found.errors) == 3
    assert found.effects.empty
