"""Whether this service sends e-mail: pages and API have nothing of it otherwise."""

from seamark.server.web.problems import Problem
from seamark.server.web.services import services


def require_mail() -> None:
    """Answer as if there were nothing where no mail server is set."""
    if not services().settings.mail_url:
        raise Problem("not-found", "This service sends no e-mail.")
