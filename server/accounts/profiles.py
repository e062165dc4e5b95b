"""What users say about themselves on their own page."""

from dataclasses import dataclass
from urllib.parse import urlsplit

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts import accounts
from seamark.server.database.tables import User

NAME_MAX, AFFILIATION_MAX, URL_MAX = 80, 120, 300  # [character]


class ProfileRejected(Exception):
    """A value breaks a rule. `errors` has field -> sentence for the user."""

    def __init__(self, errors: dict[str, str]) -> None:
        self.errors = errors
        super().__init__(" ".join(errors.values()))


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """The profile of a user; an empty value is not shown."""

    public_name: str = ""
    affiliation: str = ""
    paper_url: str = ""
    code_url: str = ""


def of(user: User) -> Profile:
    """Return the profile of a user."""
    return Profile(
        public_name=user.public_name,
        affiliation=user.affiliation,
        paper_url=user.paper_url,
        code_url=user.code_url,
    )


def find(session: Session, name: str) -> User | None:
    """Return the user of a name, in whatever case; baselines have no profile."""
    if len(name) > accounts.NAME_MAX or not name.isprintable():
        return None
    query = select(User).where(User.name_key == name.casefold(), User.is_baseline.is_(False))
    return session.scalar(query)


def store(session: Session, user_id: int, profile: Profile) -> Profile:
    """Store the profile of a user without spaces at the ends; raises ProfileRejected."""
    clean = Profile(
        public_name=profile.public_name.strip(),
        affiliation=profile.affiliation.strip(),
        paper_url=profile.paper_url.strip(),
        code_url=profile.code_url.strip(),
    )
    errors = _errors(clean)
    if errors:
        raise ProfileRejected(errors)
    user = session.get_one(User, user_id)
    user.public_name, user.affiliation = clean.public_name, clean.affiliation
    user.paper_url, user.code_url = clean.paper_url, clean.code_url
    return clean


def _errors(profile: Profile) -> dict[str, str]:
    errors: dict[str, str] = {}
    texts = {
        "public_name": (profile.public_name, NAME_MAX),
        "affiliation": (profile.affiliation, AFFILIATION_MAX),
    }
    for name, (text, most) in texts.items():
        if len(text) > most:
            errors[name] = f"At most {most} characters."
        elif visible_text(text) != text:
            errors[name] = "Only letters, digits, spaces and punctuation."
    for name, url in (("paper_url", profile.paper_url), ("code_url", profile.code_url)):
        if url and not _is_web_address(url):
            errors[name] = (
                f"A web address that starts with https:// or http://, at most {URL_MAX} characters."
            )
    return errors


def _is_web_address(url: str) -> bool:
    """Return whether a link to it leads to a web site and does nothing else."""
    if len(url) > URL_MAX or any(ord(c) <= 32 or ord(c) > 126 for c in url):
        return False
    try:
        parts = urlsplit(url)
        return parts.scheme in ("http", "https") and bool(parts.hostname) and not parts.username
    except ValueError:
        return False
