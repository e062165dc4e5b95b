import time
from contextlib import closing

import pytest
from argon2 import Type, extract_parameters
from argon2.exceptions import VerifyMismatchError
from sqlalchemy import update

from seamark.server.accounts import accounts
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.permissions import ADMIN, READ, SUBMIT, Role
from seamark.server.database.engine import Database
from seamark.server.database.tables import Token
from seamark.server.settings import Settings
from tests.conftest import HASHER_OF_SERVICE

PASSWORD = "correct horse battery"


@pytest.mark.slow
def test_a_password_signs_in_to_its_own_account_only(database: Database) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "Ann", PASSWORD)
        accounts.sign_up(session, "bob", "another pass phrase")

        assert accounts.authenticate(session, "ann", PASSWORD) is ann
        assert accounts.authenticate(session, "bob", PASSWORD) is None
        assert accounts.authenticate(session, "cat", PASSWORD) is None


def test_the_service_hashes_passwords_at_the_cost_that_owasp_asks_for() -> None:
    # At least 19 MiB and two passes (OWASP Password Storage Cheat Sheet, Argon2id).
    assert HASHER_OF_SERVICE.type is Type.ID
    assert HASHER_OF_SERVICE.memory_cost >= 19 << 10
    assert HASHER_OF_SERVICE.time_cost >= 2


def test_nobody_can_sign_in_to_an_account_without_a_password(database: Database) -> None:
    with database.writing() as session:
        accounts.sign_up(session, "robot", None)

        assert accounts.authenticate(session, "robot", "") is None


@pytest.mark.slow
def test_an_unknown_name_costs_as_much_as_a_wrong_password() -> None:
    real, drawn = HASHER_OF_SERVICE.hash(PASSWORD), accounts._hash_of_no_password(HASHER_OF_SERVICE)

    with pytest.raises(VerifyMismatchError):  # a damaged one would cost nothing
        HASHER_OF_SERVICE.verify(drawn, PASSWORD)
    assert extract_parameters(drawn) == extract_parameters(real)


@pytest.mark.parametrize("name", ["", "a", "1ann", "ann lee", "ann\n", "x" * 41, "änn", "Seamark"])
def test_a_name_that_breaks_the_rule_is_refused(database: Database, name: str) -> None:
    with database.writing() as session, pytest.raises(AccountRejected):
        accounts.sign_up(session, name, PASSWORD)


def test_names_that_differ_only_in_case_are_the_same(database: Database) -> None:
    with database.writing() as session:
        accounts.sign_up(session, "Ann", PASSWORD)

        with pytest.raises(AccountRejected, match="taken"):
            accounts.sign_up(session, "aNN", PASSWORD)


def test_a_short_password_is_refused(database: Database) -> None:
    with database.writing() as session, pytest.raises(AccountRejected, match="10 to 200"):
        accounts.sign_up(session, "ann", "short")


def test_a_token_authorizes_its_user_within_its_scopes(database: Database) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None, role=Role.ADMIN)
        text = accounts.new_token(session, ann.id, "laptop", [READ, SUBMIT])

        viewer = accounts.viewer_of_token(session, text)

    assert viewer is not None
    assert (viewer.user_id, viewer.scopes) == (ann.id, frozenset({READ, SUBMIT}))
    assert ADMIN not in viewer.scopes


def test_the_text_of_a_token_is_not_stored(database: Database) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)
        text = accounts.new_token(session, ann.id, "laptop", [READ])
        (token,) = accounts.tokens(session, ann.id)

    assert text not in str(vars(token))


def test_expired_revoked_and_unknown_tokens_authorize_nobody(database: Database) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)
        old = accounts.new_token(session, ann.id, "old", [READ])
        session.execute(update(Token).values(expires_at=time.time() - 1))
        gone = accounts.new_token(session, ann.id, "gone", [READ])
        accounts.revoke_token(session, ann.id, accounts.tokens(session, ann.id)[0].id)

        found = [accounts.viewer_of_token(session, text) for text in (old, gone, "smk_x", "")]

    assert found == [None] * 4


def test_the_use_of_a_token_is_recorded_but_not_at_every_request(
    database: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)
        text = accounts.new_token(session, ann.id, "laptop", [READ])
        accounts.new_token(session, ann.id, "unused", [READ])

    def used_at(now: float) -> list[float | None]:
        monkeypatch.setattr(time, "time", lambda: now)
        assert accounts.use_token(database, text) is not None
        with database.reading() as session:
            return [token.last_used_at for token in accounts.tokens(session, ann.id)]

    now = time.time()
    assert used_at(now) == [None, now]
    assert used_at(now + 599.0) == [None, now]
    assert used_at(now + 601.0) == [None, now + 601.0]


def test_a_token_is_good_for_reading_while_nothing_can_be_written(
    settings: Settings, database: Database
) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)
        text = accounts.new_token(session, ann.id, "laptop", [READ])

    with closing(Database(settings.database_url, busy_s=0.01)) as other, database.writing():
        assert accounts.use_token(other, text) is not None


def test_only_the_owner_can_revoke_a_token(database: Database) -> None:
    with database.writing() as session:
        ann, bob = (accounts.sign_up(session, name, None) for name in ("ann", "bob"))
        text = accounts.new_token(session, ann.id, "laptop", [READ])
        (token,) = accounts.tokens(session, ann.id)

        assert not accounts.revoke_token(session, bob.id, token.id)
        assert accounts.viewer_of_token(session, text) is not None


def test_a_token_with_an_unknown_scope_is_refused(database: Database) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)

        with pytest.raises(AccountRejected, match="root"):
            accounts.new_token(session, ann.id, "laptop", ["root"])


def test_the_hash_of_a_guest_depends_on_the_secret_of_the_service(settings: Settings) -> None:
    other = settings.model_copy(update={"secret_key": "another"})

    assert accounts.guest_hash(settings, "c") == accounts.guest_hash(settings, "c")
    assert accounts.guest_hash(settings, "c") != accounts.guest_hash(other, "c")
    assert accounts.guest_hash(settings, "c") != accounts.guest_hash(settings, "d")


def test_an_account_has_at_most_fifty_tokens(database: Database) -> None:
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)
        for _ in range(accounts.TOKENS_MAX):
            accounts.new_token(session, ann.id, "script", [READ])

        with pytest.raises(AccountRejected, match="already have 50 tokens"):
            accounts.new_token(session, ann.id, "script", [READ])
