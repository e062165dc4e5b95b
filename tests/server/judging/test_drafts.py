"""Drafts: what an organiser may write, and what the check leaves behind."""

import pytest

from seamark.competitions.document import DocumentInvalid
from seamark.server.competitions import competitions
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.judging import check, drafts
from tests.cast import Backend
from tests.server.judging.cup import DAY_S, NAME, Cup, round_of, values


def made(backend: Backend, **changes: object) -> Cup:
    draft = drafts.read(values(**changes), backend.settings)
    with backend.database.writing() as session:
        name = drafts.create(session, backend.user_id("olga"), draft, backend.settings)
        found = competitions.find(session, name)
    assert found is not None
    return Cup(backend, found.id)


def test_a_new_draft_is_checked_by_the_reference_entries(both: Backend) -> None:
    cup = made(both)

    assert len(cup.live()) == len(cup.asked.base.baselines)
    with both.database.reading() as session:
        assert check.view(session, cup.view).waiting == len(cup.live())


def test_a_changed_draft_is_checked_again_and_forgets_the_earlier_check(both: Backend) -> None:
    cup = made(both)
    first = cup.live()
    changed = drafts.read(values(title="Reef Cup"), both.settings)
    with both.database.writing() as session:
        forgotten = drafts.change(session, cup.view, changed, both.settings)

    assert sorted(forgotten) == first
    assert not set(cup.live()) & set(first)
    assert cup.asked.title == "Reef Cup"


def test_a_draft_opens_only_after_its_check(backend: Backend) -> None:
    cup = made(backend)

    with backend.database.writing() as session, pytest.raises(CompetitionRefused, match="Wait"):
        check.open_up(session, cup.view)


def test_an_open_competition_is_neither_changed_nor_deleted(backend: Backend) -> None:
    cup = Cup.opened(backend)
    changed = drafts.read(values(title="Reef Cup"), backend.settings)

    with backend.database.writing() as session:
        with pytest.raises(CompetitionRefused, match="new version"):
            drafts.change(session, cup.view, changed, backend.settings)
        with pytest.raises(CompetitionRefused, match="cannot be deleted"):
            drafts.remove(session, cup.view)


def test_a_name_is_given_once(backend: Backend) -> None:
    made(backend)

    with pytest.raises(CompetitionRefused, match=f"There is a competition {NAME}"):
        made(backend)


def test_a_deleted_draft_leaves_no_run_in_the_queue(both: Backend) -> None:
    cup = made(both)
    with both.database.writing() as session:
        drafts.remove(session, cup.view)

    assert both.claim() is None


def test_the_report_warns_of_a_competition_without_a_final(backend: Backend) -> None:
    cup = Cup.draft(backend, rounds=[round_of("qualification", -DAY_S, DAY_S, trials=3)])
    cup.check()
    with backend.database.reading() as session:
        findings = check.view(session, cup.view).findings

    assert "the best of 5 submissions" in findings[-1].sentence


@pytest.mark.parametrize(
    ("wrong", "place", "sentence"),
    [
        ({"settings": {"levels": [9.0]}}, "settings.levels", "must be"),
        ({"settings": {"kp": 1.0}}, "settings.kp", "chosen by those who take part"),
        ({"settings": {"level_duration_s": 1e9}}, "settings.level_duration_s", "must be"),
        ({"benchmark": "reef-v1"}, "benchmark", "Choose one of"),
        ({"picture_url": "x"}, "picture_url", "spelled"),
    ],
)
def test_a_wrong_place_of_a_document_is_named(
    backend: Backend, wrong: dict[str, object], place: str, sentence: str
) -> None:
    with pytest.raises(DocumentInvalid) as caught:
        drafts.read(values(**wrong), backend.settings)

    assert sentence in caught.value.errors[place]


def test_a_picture_is_one_by_its_content(backend: Backend) -> None:
    with pytest.raises(DocumentInvalid, match="PNG or JPEG"):
        drafts.read(values(), backend.settings, picture=b"<svg/>")
    assert drafts.read(values(), backend.settings, picture=b"\x89PNG\r\n\x1a\nrest").picture
