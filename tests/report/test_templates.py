"""A user's own template changes blocks of the page, in a sandbox; errors are one line."""

import time

import pytest

from shakerproc.errors import LogError
from shakerproc.report.page.page import Report, html, tried_header
from shakerproc.report.page.sections import HeaderView, read_template
from shakerproc.testlog import read_testlog

BASE = '{% extends "report.html.j2" %}\n'


def page(tmp_path, text):
    path = tmp_path / "customer.j2"
    path.write_text(text, encoding="utf-8")
    return html(Report("A<b>", (), header=HeaderView((), template=read_template(path))))


def test_a_block_is_changed_text_stays_inert_and_the_policy_is_kept(tmp_path):
    text = page(tmp_path, BASE + "{% block end %}<p>Signed: {{ page.title }}</p>{% endblock %}")
    assert "<p>Signed: A&lt;b&gt;</p>" in text
    assert text.index("Content-Security-Policy") < text.index("<body")
    assert page(tmp_path, BASE) == html(Report("A<b>", (), header=HeaderView(())))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<h1>mine</h1>", "line 1: expected {% extends"),
        ('{% extends "other.html" %}', "line 1: expected {% extends"),
        (BASE + "{% block end %}\n{% if %}", "line 3: Expected an expression"),
        (BASE + "\n{% block end %}{{ page.nothing }}{% endblock %}", "line 3: "),
        (BASE + "{% block end %}{{ page.__class__ }}{% endblock %}", "unsafe"),
        (BASE + "{% block end %}{{ page.rows.append(1) }}{% endblock %}", "line 2: "),
        (BASE + "{% block end %}{{ 1 / 0 }}{% endblock %}", "line 2: division by zero"),
        (BASE + "{% include '/etc/passwd' %}", "line 2: no template /etc/passwd"),
        (
            BASE + "{% block end %}{{ range(1000000000) | list }}{% endblock %}",
            "ranges of more",
        ),
        (
            BASE + "{% block end %}{% for a in range(1000) %}{% for b in range(1000) %}"
            "{% endfor %}{% endfor %}{% endblock %}",
            "line 2: ranges of more than 100000 items",
        ),
        (BASE + "{% block end %}{{ 10 ** (10 ** 10) }}{% endblock %}", "line 2: "),
        (
            BASE + "{% block end %}{{ 'x' * 20000000000 }}{% endblock %}",
            "line 2: it takes more than 1 GB",
        ),
        (
            BASE + "{% block end %}{% set n = namespace(x='abc') %}{% for i in range(60) %}"
            "{% set n.x = n.x ~ n.x %}{% endfor %}{% endblock %}",
            "line 2: it takes more than 1 GB",
        ),
        (BASE + "\n{% block ende %}{% endblock %}", "line 3: the page has no block"),
    ],
)
def test_what_a_template_must_not_is_one_line(tmp_path, text, told):
    with pytest.raises(LogError) as caught:
        page(tmp_path, text)
    message = str(caught.value)
    assert message.startswith("customer.j2: ")
    assert told in message
    assert "\n" not in message


@pytest.mark.parametrize("wrong", ["run.nothing", "run.flags[0].nothing", "run.peaks[9][9]"])
def test_an_error_that_only_a_run_shows_is_told_before_any_work(tmp_path, wrong):
    inside = f"{{% for run in page.runs %}}{{{{ {wrong} }}}}{{% endfor %}}"
    (tmp_path / "customer.j2").write_text(BASE + "{% block end %}" + inside + "{% endblock %}")
    log = tmp_path / "log.yaml"
    log.write_text(
        "testlog: 1\ntitle: A\nreport: {template: customer.j2}\n"
        "tests: [{id: 1, recording: none.tdms}]\n"
    )
    with pytest.raises(LogError, match=r"customer\.j2: line 2: "):
        tried_header(read_testlog(log))


@pytest.mark.parametrize(
    "inside",
    [
        "{% set s = 'x' * 1000000 %}{% for a in s %}{% for b in s %}{% endfor %}{% endfor %}",
        "{% macro f(n) %}{% if n > 0 %}{{ f(n - 1) }}{{ f(n - 1) }}{% endif %}{% endmacro %}"
        "{{ f(60) }}",
        "{% set n = namespace(a=3) %}{% for a in 'x' * 4000000 %}{% set n.a = n.a * n.a %}"
        "{% endfor %}{{ n.a }}",
    ],
    ids=["loops over text", "recursion", "products of products"],
)
def test_a_template_without_end_is_one_line_soon(tmp_path, monkeypatch, inside):
    monkeypatch.setattr("shakerproc.report.page.sections.MOST_SECONDS", 1.0)
    start = time.perf_counter()
    with pytest.raises(LogError, match=r"customer\.j2: line 2: it takes more than 1 s"):
        page(tmp_path, BASE + "{% block end %}" + inside + "{% endblock %}")
    assert time.perf_counter() - start < 5.0


def test_a_product_is_exact_as_far_as_a_number_is(tmp_path):
    text = BASE + "{% block end %}[{{ 3 * 4 }}|{{ 'ab' * 2 }}|{{ 2.5 * 4 }}]{% endblock %}"
    assert "[12|abab|10.0]" in page(tmp_path, text)
