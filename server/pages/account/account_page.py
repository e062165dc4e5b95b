"""The account page with all its sections, one of which may say what went wrong."""

from flask import g, render_template

from seamark.server.accounts import accounts, browser_sessions, identities, profiles
from seamark.server.accounts.permissions import Action, can
from seamark.server.mail import addresses
from seamark.server.web import authentication
from seamark.server.web.services import services


def render(**errors: str) -> str:
    """Return the page; `errors` has a sentence for a section: password, mail, identity, delete."""
    with services().database.reading() as database:
        text = authentication.session_text()
        browsers = browser_sessions.of_account(database, g.viewer.user_id, text)
        tokens = len(accounts.tokens(database, g.viewer.user_id))
        user = accounts.person(database, g.viewer.name)
        profile, has_password = profiles.of(user), user.password_hash is not None
        identity = identities.of_account(database, user.id, services().settings.oidc_issuer)
        mail = addresses.of_account(database, g.viewer.user_id)
    return render_template(
        "account/show.html",
        browsers=browsers,
        tokens=tokens,
        profile=profile,
        mail=mail,
        identity=identity,
        has_password=has_password,
        notify_choices=notify_choices(mail.notify_minutes),
        address_max=addresses.ADDRESS_MAX,
        hours=addresses.HOURS,
        may_invite=can(g.viewer, Action.INVITE),
        errors=errors,
        password_min=accounts.PASSWORD_MIN,
        password_max=accounts.PASSWORD_MAX,
        name_max=accounts.NAME_MAX,
    )


def notify_choices(chosen: int | None) -> list[tuple[int, str]]:
    """Return how long a run may take before its end is worth an e-mail: minutes and label."""
    minutes = {*addresses.NOTIFY_MINUTES, *(() if chosen is None else (chosen,))}
    return [(each, _duration(each)) for each in sorted(minutes)]


def _duration(minutes: int) -> str:
    hours, rest = divmod(minutes, 60)
    if hours and not rest:
        return f"{hours} hour{'s' if hours > 1 else ''}"
    return f"{minutes} minute{'' if minutes == 1 else 's'}"
