"""The page of the functions says all of each of them, and nothing that there is not."""

import inspect

import pytest
from tests.docs.test_manual import script

import shakerproc
from shakerproc.workflows.processing_options import Options

page = script("api_page")


@pytest.mark.parametrize("name", shakerproc.API)
def test_every_argument_of_a_function_is_documented_and_every_one_that_is_documented_is_there(
    name,
):
    function = getattr(shakerproc, name)
    sections = page._SECTION.split(inspect.getdoc(function))[1:]
    documented = dict(zip(sections[::2], sections[1::2], strict=True))
    items = page._ITEM.findall(documented.get("Parameters", ""))
    named = [one.strip("*") for head, _ in items for one in head.split(" : ")[0].split(", ")]
    assert sorted(named) == sorted(inspect.signature(function).parameters)
    assert f"### {name}\n" in page.functions()


def test_every_result_and_every_option_is_on_the_page():
    shown = page.results()
    for made in page.result_classes():
        assert f"### {made.__name__}\n" in shown
        assert "**`.to_pandas(" in shown
    _, _, options = shown.partition("### Options\n")
    for name in Options.__annotations__:
        assert name in options


def test_marks_of_the_docstrings_do_not_reach_the_page():
    for text in (page.functions(), page.results()):
        assert "----" not in text
        assert ":math:" not in text
