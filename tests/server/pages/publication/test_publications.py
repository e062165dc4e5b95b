import re
from html import unescape

import pytest

from tests.server.pages.conftest import Site


def test_a_run_is_published_on_the_terms_that_its_owner_chose_on_the_form(site: Site) -> None:
    run_id, ann = site.succeeded("ann", controller="upload", program=site.store_program()), "ann"
    browser = site.browser(ann)
    chosen = {"content": "program", "licence": "MIT", "author": "anonymous"}
    chosen |= {"method": "Steady hand"}

    form = browser.get(f"/runs/{run_id}/publish").text
    answer = browser.post(f"/runs/{run_id}/publish", chosen)

    assert "Apache-2.0" in form
    assert answer.status_code == 303
    run = site.show(run_id)
    assert (run.public, run.licence, run.anonymous, run.program_public) == (True, "MIT", True, True)
    assert "Anonymous author" in site.browser().get(f"/runs/{run_id}").text
    browser.post(f"/runs/{run_id}/reveal")
    assert "by ann" in site.browser().get(f"/runs/{run_id}").text


def test_terms_that_are_not_possible_are_explained_on_the_form_with_what_was_chosen(
    site: Site,
) -> None:
    site.published("ann", kind="ranked")
    run_id = site.succeeded("ann", kind="ranked")

    answer = site.browser("ann").post(f"/runs/{run_id}/publish", {"author": "anonymous"})

    assert answer.status_code == 422
    assert "The leaderboard has one row for each user" in answer.text
    assert 'value="anonymous" checked' in answer.text
    assert not site.show(run_id).public


def test_a_permanent_address_leads_to_the_run_and_later_says_that_it_was_withdrawn(
    site: Site,
) -> None:
    run_id = site.published("ann")
    address = f"/p/{run_id}"

    found = site.browser().get(address)
    site.browser("ann").post(f"/runs/{run_id}/withdraw")
    gone = site.browser().get(address)

    assert (found.status_code, found.location) == (302, f"/runs/{run_id}")
    assert gone.status_code == 410
    assert "ann" not in gone.text.split("<main")[1].split("</main")[0].replace("cannot", "")
    assert f"Run {run_id} was published on" in gone.text
    assert site.browser().get("/p/999999").status_code == 404


def test_a_method_is_shown_by_its_name_and_not_by_its_file(site: Site) -> None:
    program = site.store_program(name="controller.py")
    run_id = site.succeeded("ann", kind="ranked", controller="upload", program=program)
    form = site.browser("ann").get(f"/runs/{run_id}/publish").text
    site.browser("ann").post(f"/runs/{run_id}/publish", {"method": "Observer <7>"})

    pages = ("/leaderboards/currents-v1", "/users/ann", f"/api/v1/runs/{run_id}/badge.svg")
    shown = {path: site.browser().get(path).text for path in pages}

    assert 'name="method" value=""' in form
    assert [path for path, text in shown.items() if "Observer &lt;7&gt;" not in text] == []
    assert [path for path, text in shown.items() if "controller.py" in text] == []
    cited = site.browser().get(f"/api/v1/runs/{run_id}/citation.bib").text
    assert "title = {{Observer <7>}}" in cited


def test_a_public_run_has_snippets_to_copy_that_say_what_it_is(site: Site) -> None:
    run_id = site.published("ann")
    name = f"Run {run_id} of currents-v1 on Seamark (practice, 1 trial)"
    address, badge = f"http://localhost/p/{run_id}", f"/api/v1/runs/{run_id}/badge.svg"

    page = site.browser().get(f"/runs/{run_id}").text
    embed = site.browser().get(f"/runs/{run_id}/embed").text

    card = page.partition('id="cite-title"')[2].partition("</section>")[0]
    blocks = re.findall(r"<pre[^>]*>(.*?)</pre>.*?data-copy-code", card, re.DOTALL)
    shown = [unescape(re.sub("<[^>]+>", "", block)) for block in blocks]
    assert shown[1] == f"[![{name}](http://localhost{badge})]({address})"
    assert shown[2] == f'<a href="{address}"><img src="http://localhost{badge}" alt="{name}"></a>'
    assert shown[3].startswith(f'<iframe src="http://localhost/runs/{run_id}/embed" title="{name}"')
    assert "practice, 1 trial" in embed.partition("<h1>")[2].partition("</h1>")[0]


@pytest.mark.parametrize("state", ["queued", "public"])
def test_the_form_leads_back_where_there_is_nothing_to_publish(site: Site, state: str) -> None:
    run_id = site.queue("ann") if state == "queued" else site.published("ann")

    answer = site.browser("ann").get(f"/runs/{run_id}/publish")

    assert (answer.status_code, answer.location) == (303, f"/runs/{run_id}")


@pytest.mark.slow
def test_the_page_of_a_public_run_cites_it_and_its_owner_can_have_it_verified(site: Site) -> None:
    run_id = site.published("ann", kind="ranked", title="R&D <b>")
    ann = site.browser("ann")

    before = ann.get(f"/runs/{run_id}").text
    ann.post(f"/runs/{run_id}/verify")
    pending = ann.get(f"/runs/{run_id}").text
    site.finish(site.claim_next(), score=51.0)
    after = site.browser().get(f"/runs/{run_id}").text
    board = site.browser().get("/leaderboards/currents-v1").text

    assert "seamark-run" in before
    assert "Verify on fresh trials" in before
    assert "Verify on fresh trials" not in site.browser().get(f"/runs/{run_id}").text
    assert "is being verified" in pending
    assert "Evaluated again on fresh trials on" in after
    assert ">verified<" in after
    assert ">verified<" in board
    assert "<b>" not in after.partition("<main")[2].partition("cite-title")[2]
