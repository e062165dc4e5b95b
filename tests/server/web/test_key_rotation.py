"""Rotating the secret key ends sessions of browsers; API tokens stay."""

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.web import authentication
from tests.cast import Backend


def _signed_cookie(backend: Backend) -> str:
    """Return the session cookie of ann's browser, signed with the present secret key."""
    app = create_app(backend.settings)
    with app.app_context():
        cookie = authentication.cookie_of(backend.user_id("ann"))
    client = app.test_client()
    with client.session_transaction() as session:
        session.update(cookie)
    app.extensions["seamark"].close()
    found = client.get_cookie("seamark")
    assert found is not None
    return found.value


def test_with_another_secret_key_browsers_are_signed_out_and_tokens_stay(backend: Backend) -> None:
    cookie = _signed_cookie(backend)
    with backend.database.writing() as session:
        token = accounts.new_token(session, backend.user_id("ann"), "laptop", ("read",))

    names = {}
    for key in (backend.settings.secret_key, "another secret"):
        app = create_app(backend.settings.model_copy(update={"secret_key": key}))
        client = app.test_client()
        client.set_cookie("seamark", cookie)
        by_cookie = client.get("/api/v1/me").get_json()
        bearer = {"Authorization": f"Bearer {token}"}
        by_token = app.test_client().get("/api/v1/me", headers=bearer).get_json()
        names[key] = (by_cookie.get("name"), by_token["name"])
        app.extensions["seamark"].close()

    assert names[backend.settings.secret_key] == ("ann", "ann")
    assert names["another secret"][0] != "ann"
    assert names["another secret"][1] == "ann"
