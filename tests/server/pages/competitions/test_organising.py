"""Organisers make drafts by the form, open them, and look after what is open."""

import csv
import io
import re
import time
from datetime import UTC, datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

import pytest

from seamark.server.competitions import competitions
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.pages.competitions import draft_form
from tests.cast import MARKER, RECORD, VEHICLE
from tests.server.judging.cup import NAME, Cup
from tests.server.pages.conftest import Site

PNG = b"\x89PNG\r\n\x1a\n" + b"0" * 30
MADRID = ZoneInfo("Europe/Madrid")
PAGE = f"/competitions/{NAME}"


def at(days: float, zone: Any = UTC) -> str:
    return (datetime.now(zone) + timedelta(days=days)).strftime("%Y-%m-%dT%H:%M")


def form(**changes: Any) -> dict[str, Any]:
    """Return the fields of a competition with a qualification alone."""
    return {
        "title": "Harbour Cup",
        "asks": "Who keeps station?",
        "rules": "Be fair.\r\n\r\nHave fun.",
        "zone": "Europe/Madrid",
        "source": "benchmark",
        "benchmark": "currents-v1",
        "practice1.opens": "nonsense, but the box is not ticked",
        "qualification.opens": at(1, MADRID),
        "qualification.closes": at(3, MADRID),
        "qualification.quota": "4",
        "qualification.trials": "3",
    } | changes


def found(site: Site, name: str = NAME) -> CompetitionView | None:
    with site.database.reading() as session:
        return competitions.find(session, name)


def file(content: bytes, name: str) -> tuple[io.BytesIO, str]:
    return io.BytesIO(content), name


def test_a_form_makes_a_draft_whose_name_comes_from_the_title_and_has_it_checked(
    site: Site,
) -> None:
    answer = site.browser("olga").post("/competitions/new", form())
    page = site.browser("olga").get(answer.headers["Location"]).text

    made = found(site)
    assert made is not None
    document = made.document
    assert (document.title, document.question) == ("Harbour Cup", "Who keeps station?")
    assert document.rules == "Be fair.\n\nHave fun."
    assert document.qualification.opens == datetime.fromisoformat(at(1, MADRID)).replace(
        tzinfo=MADRID
    )
    assert (document.qualification.quota, document.qualification.trials) == (4, 3)
    assert [one.kind for one in document.rounds] == ["qualification"]
    assert "Check under way" in page
    assert "data-live" in page
    assert f"0 of {len(document.base.baselines)} reference entries have ended" in page


def test_the_form_begins_with_practice_qualification_and_final(site: Site) -> None:
    page = site.browser("olga").get("/competitions/new").text

    names = re.findall(r'name="([a-z0-9]+\.opens)" value="(\d{4}-\d\d-\d\dT\d\d:00)"', page)
    assert [name for name, _ in names] == ["practice1.opens", "qualification.opens", "final.opens"]
    assert [value for _, value in names] == sorted(value for _, value in names)
    assert page.count(" checked>") >= 2


@pytest.mark.parametrize(
    ("changes", "field", "sentence"),
    [
        ({"title": ""}, "title", "Field required."),
        ({"name": "Harbour"}, "name", "then the version"),
        ({"zone": "Mars/Olympus"}, "zone", "Must be a time zone"),
        ({"qualification.quota": "0"}, "qualification.quota", "greater than or equal to 1"),
        ({"qualification.closes": at(0, MADRID)}, "qualification.closes", "after it has opened"),
        ({"final.used": "on", "final.opens": "soon"}, "final.opens", "valid datetime"),
        ({"benchmark": "chess-v1"}, "source", "no such benchmark"),
        ({"source": "run", "run": "77"}, "run", "Choose one of your runs."),
        ({"picture": file(b"GIF89a", "a.gif")}, "picture", "must be a PNG or JPEG file"),
        ({"vehicle_file": file(b"x = 1", "v.toml")}, "vehicle_file", ""),
        ({"current_record": file(b"x,y", "r.csv")}, "current_record", "begins with"),
        ({"target_texture": file(b"x,y", "a.png")}, "target_texture", "can be decoded"),
        ({"document": file(b"title = ", "c.toml")}, "document", "not valid TOML"),
        ({"document": file(b'title = "T"\n', "c.toml")}, "document", "name: Field required."),
    ],
)
def test_an_error_stands_at_its_field_and_nothing_that_was_typed_is_lost(
    site: Site, changes: dict[str, Any], field: str, sentence: str
) -> None:
    sent = form(**changes)

    answer = site.browser("olga").post(
        "/competitions/new", sent, content_type="multipart/form-data"
    )

    assert answer.status_code == 422
    error = re.search(rf'id="{re.escape(field)}-error" role="alert">(.*?)</p>', answer.text)
    assert error is not None
    assert sentence in error[1]
    assert "Be fair." in answer.text
    assert 'name="asks" value="Who keeps station?"' in answer.text
    assert 'name="qualification.trials" value="3"' in answer.text
    assert found(site) is None


def test_a_name_that_the_title_would_give_is_not_asked_for(site: Site) -> None:
    page = site.browser("olga").post("/competitions/new", form(title="")).text

    assert 'id="title-error"' in page
    assert 'id="name-error"' not in page


def kept_in(page: str) -> dict[str, str]:
    """Return the hidden fields by which a form keeps files."""
    return dict(re.findall(r'name="(kept_\w*)" value="([^"]+)"', page))


def test_the_files_of_settings_stay_when_something_else_was_wrong(site: Site) -> None:
    files = {"vehicle_file": file(VEHICLE.encode(), "v.toml")}
    files["current_record"] = file(RECORD.encode(), "r.csv")
    multipart = {"content_type": "multipart/form-data"}
    olga = site.browser("olga")

    page = olga.post("/competitions/new", form(title="", **files), **multipart).text
    again = olga.post("/competitions/new", form(title="", **kept_in(page)), **multipart).text
    olga.post("/competitions/new", form(**kept_in(again)), **multipart)

    assert again.count("The file that you chose before has been kept.") == 2
    made = found(site)
    assert made is not None
    assert made.vehicle_sha256 is not None
    assert set(made.files) == {"current_record"}
    assert {"vehicle", "current_record"} <= made.document.settings.keys()


def test_a_file_without_its_setting_in_the_benchmark_is_not_kept(site: Site) -> None:
    """Else nobody could choose none instead."""
    sent = form(target_texture=file(MARKER, "a.pgm"))  # of the benchmark of currents
    multipart = {"content_type": "multipart/form-data"}

    page = site.browser("olga").post("/competitions/new", sent, **multipart).text

    assert 'id="target_texture-error"' in page
    assert kept_in(page) == {}


def test_a_kept_file_belongs_to_its_sender_and_to_its_setting(site: Site) -> None:
    multipart = {"content_type": "multipart/form-data"}
    sent = form(title="", current_record=file(RECORD.encode(), "r.csv"))
    page = site.browser("olga").post("/competitions/new", sent, **multipart).text
    text = kept_in(page)["kept_current_record"]

    for who, field in (("root", "kept_current_record"), ("olga", "kept_target_texture")):
        site.browser(who).post("/competitions/new", form(**{field: text}), **multipart)
        made = found(site)
        assert made is not None
        assert made.files == {}
        with site.database.writing() as session:
            competitions.remove_draft(session, made)


def test_the_settings_of_a_practice_run_become_those_of_the_competition(site: Site) -> None:
    run_id = site.queue("olga", config={"levels": [0.1, 0.3], "kp": 0.9})

    offered = site.browser("olga").get(f"/competitions/new?run={run_id}").text
    site.browser("olga").post("/competitions/new", form(source="run", run=str(run_id)))

    made = found(site)
    assert made is not None
    assert made.document.settings["levels"] == [0.1, 0.3]
    assert "kp" not in made.document.settings  # solutions choose it
    assert re.search(rf'<option value="{run_id}" selected>', offered)
    assert re.search(r'value="run" checked', offered)


def test_a_toml_file_takes_the_place_of_the_fields_and_the_picture_is_the_forms(
    site: Site,
) -> None:
    times = f'opens = "{at(1)}"\ncloses = "{at(2)}"'
    toml = f"""
name = "river-cup-v2"
title = "River Cup"
benchmark = "currents-v1"
[[rounds]]
kind = "qualification"
trials = 3
{times}
"""
    sent = form(document=file(toml.encode(), "c.toml"), picture=file(PNG, "p.png"))

    site.browser("olga").post("/competitions/new", sent, content_type="multipart/form-data")

    made = found(site, "river-cup-v2")
    assert made is not None
    assert (made.document.title, made.has_picture) == ("River Cup", True)
    picture = site.browser("olga").get("/competitions/river-cup-v2/picture")
    assert (picture.data, picture.mimetype) == (PNG, "image/png")
    assert site.browser("ann").get("/competitions/river-cup-v2/picture").status_code == 404


def test_a_toml_file_for_the_command_line_asks_for_the_files_that_it_names(site: Site) -> None:
    toml = f"""
name = "river-cup-v1"
title = "River Cup"
benchmark = "currents-v1"
picture = "river.png"
vehicle = "my_rov.toml"
current_record = "ria.csv"
[[rounds]]
kind = "qualification"
trials = 3
opens = "{at(1)}"
closes = "{at(2)}"
"""
    olga, multipart = site.browser("olga"), {"content_type": "multipart/form-data"}

    document = {"document": file(toml.encode(), "c.toml")}
    refused = olga.post("/competitions/new", form(**document), **multipart).text
    files = {
        "document": file(toml.encode(), "c.toml"),
        "picture": file(PNG, "p.png"),
        "vehicle_file": file(VEHICLE.encode(), "v.toml"),
        "current_record": file(RECORD.encode(), "r.csv"),
    }
    olga.post("/competitions/new", form(**files), **multipart)

    assert "The TOML file names river.png: choose it here." in refused
    assert "The TOML file names my_rov.toml: choose it here." in refused
    assert "The TOML file names ria.csv: choose it here." in refused
    made = found(site, "river-cup-v1")
    assert made is not None
    assert made.has_picture
    assert made.vehicle_sha256 is not None
    assert set(made.files) == {"current_record"}


def test_a_draft_of_the_form_has_a_picture_on_its_target(site: Site) -> None:
    sent = form(benchmark="visibility-v2", target_texture=file(MARKER, "a.pgm"))
    site.browser("olga").post("/competitions/new", sent, content_type="multipart/form-data")
    made = found(site)
    assert made is not None
    before = made.files

    again = draft_form.of_document(made.document) | {"source": "kept", "title": "Cup of rivers"}
    site.browser("olga").post(f"{PAGE}/change", again)
    made = found(site)

    assert made is not None
    assert made.document.title == "Cup of rivers"
    assert set(made.files) == {"target_texture"}
    assert made.files == before


def test_a_draft_keeps_the_files_of_its_organiser(site: Site) -> None:
    cup = Cup.draft(site, vehicle=site.store_vehicle(), files=(site.store_record(),))
    cup.check()
    before, fields = cup.view, draft_form.of_document(cup.asked)

    site.browser("olga").post(f"{PAGE}/change", fields | {"title": "Cup of harbours"})

    assert cup.view.document.title == "Cup of harbours"
    assert cup.view.vehicle_sha256 == before.vehicle_sha256 is not None
    assert set(cup.view.files) == {"current_record"}
    assert cup.view.files == before.files
    assert cup.view.document.settings == before.document.settings


def test_changing_a_draft_keeps_what_is_not_changed_and_checks_it_again(site: Site) -> None:
    cup = Cup.draft(site)
    cup.check()
    before = cup.asked
    olga = site.browser("olga")
    page = olga.get(f"{PAGE}/change").text
    fields = dict(re.findall(r'name="([\w.]+)"[^>]*? value="([^"]*)"', page))
    fields |= dict(re.findall(r'<select id="([\w.]+)".*?<option value="(\w+)" selected>', page))
    fields |= {name: "on" for name in re.findall(r'name="([\w.]+)" checked', page)}
    sent = fields | {"rules": before.rules, "source": "kept", "title": "Cup of harbours"}

    answer = olga.post(f"{PAGE}/change", sent)

    assert answer.status_code == 303
    now = cup.asked
    assert now.title == "Cup of harbours"
    same = before.model_dump(mode="json") | {"title": now.title}
    assert _minutes(now.model_dump(mode="json")) == _minutes(same)
    assert "Check under way" in olga.get(PAGE).text


def _minutes(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document whose times are cut to minutes, which a form's times are."""
    for one in document["rounds"]:
        one |= {name: one[name][:16] for name in ("opens", "closes") if name in one}
    return document


def test_a_checked_draft_shows_its_report_and_opens_for_everybody(site: Site) -> None:
    later = {"opens_in_s": 3600.0, "closes_in_s": 7200.0}
    cup = Cup.draft(site)
    for one in cup.view.rounds:
        cup.shift(one.number, **later if one.closes_at else {"opens_in_s": 9000.0})
    olga = site.browser("olga")
    too_early = olga.post(f"{PAGE}/open", follow_redirects=True).text
    cup.check()

    page = olga.get(PAGE).text
    olga.post(f"{PAGE}/open")

    assert "Wait for the check to end" in too_early
    assert "data-live" not in page
    assert re.search(r'class="notice (good|warn|bad)"', page)
    assert all(baseline.title in page for baseline in cup.asked.base.baselines.values())
    assert site.browser().get(PAGE).status_code == 200


def test_a_draft_of_a_round_that_is_over_cannot_be_opened(site: Site) -> None:
    cup = Cup.draft(site)
    cup.check()

    page = site.browser("olga").get(PAGE).text
    answer = site.browser("olga").post(f"{PAGE}/open", follow_redirects=True)

    assert "Round 1 would already be closed." in page
    assert f'action="{PAGE}/open"' not in page
    assert "Round 1 would already be closed." in answer.text
    assert cup.view.is_draft


def test_a_draft_is_deleted_and_an_open_competition_is_not(site: Site) -> None:
    Cup.draft(site, name="draft-cup-v1")
    Cup.opened(site)

    for name in ("draft-cup-v1", NAME):
        site.browser("olga").post(f"/competitions/{name}/delete")

    assert found(site, "draft-cup-v1") is None
    assert found(site) is not None
    assert site.browser("olga").get(f"{PAGE}/change").status_code == 409


def test_the_end_of_a_round_moves_in_the_zone_of_the_competition_with_a_reason(
    site: Site,
) -> None:
    cup = Cup.opened(site)
    until = at(30, MADRID)

    site.browser("olga").post(f"{PAGE}/rounds/2/move", {"until": until, "reason": "Storm"})

    moved = datetime.fromisoformat(until).replace(tzinfo=MADRID).timestamp()
    assert cup.view.qualification.closes_at == moved
    assert "“<bdi>Storm</bdi>”" in site.browser().get(PAGE).text


@pytest.mark.parametrize(
    ("sent", "field"),
    [
        ({"until": at(-3, MADRID), "reason": "Storm"}, "until2"),
        ({"until": "tomorrow", "reason": "Storm"}, "until2"),
        ({"until": at(30, MADRID), "reason": " "}, "reason2"),
    ],
)
def test_a_move_that_is_refused_keeps_what_was_typed(
    site: Site, sent: dict[str, str], field: str
) -> None:
    cup = Cup.opened(site)
    before = cup.view.qualification.closes_at

    answer = site.browser("olga").post(f"{PAGE}/rounds/2/move", sent)

    assert answer.status_code == 422
    assert f'id="{field}-error"' in answer.text
    assert f'value="{sent["until"]}"' in answer.text
    assert cup.view.qualification.closes_at == before


@pytest.mark.parametrize(
    ("to", "sentence"),
    [("ann", "ann is no organiser."), ("nobody-there", "There is no account nobody-there.")],
)
def test_a_competition_is_handed_to_organisers_only(site: Site, to: str, sentence: str) -> None:
    cup = Cup.opened(site)

    refused = site.browser("olga").post(f"{PAGE}/hand-over", {"user": to})
    kept = cup.view.organiser
    site.browser("olga").post(f"{PAGE}/hand-over", {"user": "root"})

    assert refused.status_code == 422
    assert sentence in refused.text
    assert (kept, cup.view.organiser) == ("olga", "root")
    assert site.browser("olga").get(f"{PAGE}/organise").status_code == 403


def test_the_organiser_downloads_teams_and_entries_without_formulas(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben", name="=1+1")
    run_id = cup.entered("ben", [40.0, 41.0, 42.0], method="Steady")

    tables = {
        name: [*csv.DictReader(site.browser("olga").get(f"{PAGE}/{name}.csv").text.splitlines())]
        for name in ("teams", "entries")
    }

    assert [(row["team"], row["member"], row["captain"]) for row in tables["teams"]] == [
        ("'=1+1", "ann", "True"),
        ("'=1+1", "ben", "False"),
    ]
    (entry,) = tables["entries"]
    assert (entry["run"], entry["method"], entry["score"]) == (str(run_id), "Steady", "41.0")
    assert (entry["submitted_by"], entry["round"], entry["withdrawn"]) == ("ben", "2", "False")


def test_the_downloads_have_nothing_of_a_final_that_is_not_decided(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann")
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])
    cup.begin_final()
    cup.play_batch({"PI": [90.0, 91.0, 92.0] * 2})

    text = site.browser("olga").get(f"{PAGE}/entries.csv").text

    assert f",{run_id}," in text
    assert "91.0" not in text
    assert time.time() > cup.view.rounds[-1].opens_at
