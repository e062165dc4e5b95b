"""The user that a request names, if the viewer may know of the account."""

from sqlalchemy.orm import Session

from seamark.server.accounts import profiles
from seamark.server.database.tables import User
from seamark.server.runs.showing import standings
from seamark.server.web import access
from seamark.server.web.problems import Problem


def user_of(session: Session, name: str) -> User:
    """Return the user; raises Problem for one who has published nothing, as if there were none.

    Otherwise anybody could list the students of a school by guessing their names.
    """
    user = profiles.find(session, name)
    own = user is not None and user.id == access.viewer().user_id
    if user is None or not (own or standings.is_known(session, user)):
        raise Problem("not-found", "No user with this name has published anything.")
    return user
