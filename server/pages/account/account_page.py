"""The account page with all its sections, each of which may show an error."""

from flask import g, render_template

from seamark.server.accounts import accounts, browser_sessions, identities, profiles
from seamark.server.accounts.permissions import Action, can
from seamark.server.mail import addresses
from seamark.server.web import authentication
from seamark.server.web.services import services


def render(**errors: str) -> str:
    """Return the page; `errors` are sentences by section: password, mail, identity or delete."""
    with services().database.reading() as session:
        own_session = authentication.session_text()
        browsers = browser_sessions.of_account(session, g.viewer.user_id, own_session)
        tokens = len(accounts.tokens(session, g.viewer.user_id))
        user = accounts.person(session, g.viewer.name)
        profile, has_password = profiles.of(user), user.password_hash is not None
        identity = identities.of_account(session, user.id, services().settings.oidc_issuer)
        mail = addresses.of_account(session, g.viewer.user_id)
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
    """Return the choices of the shortest run whose end is e-mailed: minutes and label."""
    minutes = {*addresses.NOTIFY_MINUTES, *(() if chosen is None else (chosen,))}
    return [(each, _duration(each)) for each in sorted(minutes)]


def _duration(minutes: int) -> str:
    hours, rest = divmod(minutes, 60)
    if hours and not rest:
        return f"{hours} hour{'s' if hours > 1 else ''}"
    return f"{minutes} minute{'' if minutes == 1 else 's'}"
