"""Text that one user stores and others read: it acts on nothing that shows it."""

import csv
import io
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from itertools import product

import pytest
from werkzeug.http import parse_options_header

from seamark.server.runs.data.files import RunFiles
from seamark.server.web import csv_export
from tests.cast import PROGRAM
from tests.server.pages.conftest import Site

SCRIPTS = (
    "<script>alert(1)</script>",
    "</script><script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    '"><svg onload=alert(1)>',
    "' onmouseover='alert(1)",
    "javascript:alert(1)",
    "{{ 7919 * 104729 }}${7919 * 104729}",
    "<!--<script>",
    "]]><script>alert(1)</script>",
    "<iframe srcdoc='<script>alert(1)</script>'>",
    "<base href=//evil.example>",
    "<style>@import'//evil.example'</style>",
)
EVALUATED = str(7919 * 104729)  # long: a random token of a page should not hold it
FORMULAS = (
    *("=1+1", "+1+1", "-1+1", "@SUM(1)", "\t=1+1", "\r=1+1", "\n=1+1"),
    *(" =1+1", "  @SUM(1)", "\u3000=1+1"),
    *("\uff1d1+1", "\uff0b1", "\uff0d1", "\uff20SUM(1)", '=HYPERLINK("//evil.example")'),
)
BIDI = "abc\u202etxt.\u2066exe\u2069\u200f\u061c\u2028end"
INVISIBLE = re.compile("[\u061c\u200b-\u200f\u2028-\u202e\u2066-\u2069]")


class Markup(HTMLParser):
    """Collects what a browser would run or load: elements, handlers and addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if tag in {"iframe", "base", "object", "embed", "style"}:
            self.found.append(tag)
        if tag == "script" and not (values.get("src") or "/static/").startswith("/static/"):
            self.found.append(f"script of {values['src']}")
        if tag == "script" and "src" not in values and values.get("type") != "application/json":
            self.found.append("script")
        for name, value in attrs:
            address = value or "" if name in {"href", "src", "action", "formaction"} else ""
            if name.startswith("on") or address.lower().startswith("javascript:"):
                self.found.append(f"{tag} {name}")


def _stored(site: Site, text: str) -> int:
    """Return a public ranked run that has the text wherever its owner can write one."""
    program = site.store_program(PROGRAM, f"{text}.py".replace("/", "_"))
    detail = {"title": text, "sentence": text, "remedy": text, "traceback": text}
    site.failed(detail, "ann")
    run_id = site.queue("ann", title=text, notes=text, controller="upload", program=program)
    claim = site.claim_next()
    RunFiles(site.settings.data, run_id, 1).append_log(text.encode())
    metrics = {"score": 50.0, "score_low": 45.0, "score_high": 55.0, "level_held": 0.2}
    site.finish(claim, metrics=metrics | {"trials": [], "error": text, "not_ranked": text})
    return site.publish(run_id)


def _pages(site: Site, run_id: int) -> Iterator[tuple[str, str]]:
    for path in (f"/runs/{run_id}", f"/runs/{run_id - 1}", "/runs/", "/runs/?of=all", "/",
                 "/leaderboards/currents-v1", f"/submit/currents-v1?from={run_id}"):  # fmt: skip
        yield path, site.browser("root").get(path).text


@pytest.mark.slow
def test_no_stored_text_becomes_markup(site: Site) -> None:
    found = []
    for text in SCRIPTS:
        for path, page in _pages(site, _stored(site, text)):
            markup = Markup()
            markup.feed(page)
            found += [(text, path, what) for what in markup.found]
            found += [(text, path, "evaluated")] * (EVALUATED in page)

    assert found == []


def test_markup_in_a_page_would_be_found() -> None:
    for text in SCRIPTS[:4]:
        markup = Markup()
        markup.feed(text)
        assert markup.found


@pytest.mark.slow
def test_text_in_an_address_does_not_become_markup(site: Site) -> None:
    names, browser = ("next", "name", "invitation", "user", "from", "kp", "title"), site.browser()
    for path in ("/sign-in", "/sign-up", "/runs/", "/submit/currents-v1", "/leaderboards/none"):
        for text in SCRIPTS:
            markup = Markup()
            markup.feed(browser.get(path, query_string=dict.fromkeys(names, text)).text)
            assert markup.found == []


@pytest.mark.parametrize("formula", FORMULAS)
def test_no_cell_of_a_table_starts_a_formula(formula: str) -> None:
    text = csv_export.lines(["a"], [{"a": formula}])

    ((_, cell),) = zip(*csv.reader(io.StringIO(text, newline="")), strict=True)
    assert cell == f"'{formula}".replace("\r", " ")  # a CR would end the row


@pytest.mark.slow
@pytest.mark.parametrize("path", ["/runs/runs.csv?of=all", "/api/v1/leaderboards/currents-v1"])
def test_exports_write_titles_and_programs_as_text(site: Site, path: str) -> None:
    program = site.store_program(PROGRAM, "=cmd.py")
    site.published("ann", title="@SUM(1)", controller="upload", program=program, kind="ranked")

    answer = site.browser("root").get(path, headers={"Accept": "text/csv"})

    cells = [cell for row in csv.reader(io.StringIO(answer.text)) for cell in row]
    assert "'=cmd.py" in cells
    assert not [cell for cell in cells if cell.startswith(("=", "@", "+"))]


def test_a_title_keeps_no_character_that_is_invisible_or_turns_the_text_round(site: Site) -> None:
    browser = site.browser("ann")
    browser.post("/submit/currents-v1", {"controller": "pi", "title": BIDI})
    run = {"benchmark": "currents-v1", "controller": "pi", "title": BIDI, "notes": f"a\n{BIDI}"}
    browser.client.post("/api/v1/runs", json=run, headers={"X-CSRFToken": browser.csrf_token()})
    browser.post("/tokens", {"name": BIDI, "scopes": "read"})

    listed = browser.get("/api/v1/runs").get_json()["runs"]

    assert [run["title"] for run in listed] == ["abctxt.exeend"] * 2
    assert listed[0]["notes"] == "a\nabctxt.exeend"
    for path in ("/runs/", "/tokens"):
        assert "abctxt.exeend" in browser.get(path).text
        assert not INVISIBLE.search(browser.get(path).text)


def test_text_of_a_user_does_not_turn_round_what_stands_beside_it(site: Site) -> None:
    title = "\u05e9\u05dc\u05d5\u05dd"
    run_id = site.published("ann", title=title, kind="ranked")

    for path in (f"/runs/{run_id}", "/runs/"):
        page = site.browser("ann").get(path).text
        shown = page[page.index("<main") :].replace(f'value="{title}"', "")  # alone in a field
        shown = re.sub("<pre.*?</pre>", "", shown, flags=re.DOTALL)  # alone in a line of BibTeX
        assert shown.count(title) == shown.count(f"<bdi>{title}</bdi>") > 0


@pytest.mark.parametrize(
    "name", ['a"; filename="b.py', "a\r\nSet-Cookie: x=1.py", "\u05e9\u05dc.py", "%0d%0aX: y.py"]
)
def test_a_program_name_adds_nothing_to_the_headers_of_its_download(site: Site, name: str) -> None:
    program = site.store_program(PROGRAM, name)
    run_id = site.succeeded("ann", controller="upload", program=program)

    answer = site.browser("ann").get(f"/api/v1/runs/{run_id}/program")

    disposition = answer.headers["Content-Disposition"]
    assert answer.status_code == 200
    assert parse_options_header(disposition) == (
        "attachment",
        {"filename": f"seamark-run-{run_id}-{program.name}"},
    )
    assert not {"Set-Cookie", "X"} & set(answer.headers.keys())


PATHS = ("../../etc/passwd", "..%2f..%2fetc%2fpasswd", "%2e%2e/%2e%2e/etc/passwd", "/etc/passwd",
         "....//....//etc/passwd", "..\\..\\etc\\passwd", "..%5c..%5cetc%5cpasswd",
         "..%c0%af..%c0%afetc/passwd", "figures/../../pyproject.toml", "css/../../base.html",
         "%00/etc/passwd", "file:///etc/passwd")  # fmt: skip


@pytest.mark.slow
def test_no_route_leaves_its_folder(site: Site) -> None:
    routes = {
        rule.rule.partition("<")[0]
        for rule in site.app.url_map.iter_rules()
        if rule.methods is not None and "GET" in rule.methods and rule.arguments
    }
    assert {"/static/", "/docs/guides/", "/docs/physics/"} <= routes
    browser = site.browser("root")

    for start, path in product(sorted(routes), PATHS):
        answer = browser.get(start + path)
        assert answer.status_code in {308, 400, 404, 405, 422}, start
        assert "root:" not in answer.text
        assert "[project]" not in answer.text
