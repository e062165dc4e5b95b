"""All settings of a service, read once from the environment.

Keys that the environment does not give are drawn once, and kept in the data folder.
"""

import os
import re
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

PREFIX = "SEAMARK_"
LevelName = Literal["none", "medium", "strong"]  # of seamark.sandbox.isolation.level
LogLevel = Literal["debug", "info", "warning", "error"]
SignUp = Literal["open", "invitation", "closed"]
SIGNS_NOTHING = "a worker signs nothing"  # its secret key: it never reads that of the service
# The seed key of a worker on a machine that has none: the rows of its runs have their seeds.
DERIVES_NOTHING = "a worker derives nothing"
LOOKING = "looking"  # context of a validation that writes nothing
REMOVED = {  # setting of an earlier version -> what holds now
    "ranked_trials": "each benchmark says how many trials its ranked runs have",
    "practice_trials_max": "a practice run has at most 10 trials",
    "run_max_bytes": "a practice run may record at most 256 MiB",
    "heartbeat_s": f"it follows from {PREFIX}LEASE_S",
    "sweep_s": f"it follows from {PREFIX}LEASE_S",
    "attempts_max": "the third evaluation that breaks is a platform failure",
    "log_format": "the log is text on a terminal, otherwise JSON",
    "metrics": f"others than this machine read them with {PREFIX}METRICS_TOKEN",
    "streams_max": "a web process has at most 1,000 live streams",
}
KEY_FILES = {"secret_key": "secret", "seed_key": "seed_key"}  # of the settings -> their files
_WITHOUT = {
    "secret": "Delete it, and another one is drawn: everybody has to sign in again",
    "seed_key": "It decides the seeds of ranked runs: write the key of this service into it, from "
    "a backup or another machine. Delete it only where there have been no ranked runs",
}
DEFAULTS_IN_WORDS = {  # of settings whose default depends on others or on the machine
    "database_url": "SQLite in the data folder",
    "broker_url": "none; `seamark up` starts one",
    "secret_key": "generated once, stored in the data folder",
    "seed_key": "generated once, stored in the data folder",
    "sandbox_min_level": "`medium`; `strong` if public",
    "storage_url": "the data folder",
    "storage_endpoint": "none",
    "storage_access_key": "none",
    "storage_secret_key": "none",
    "url": "none",
    "embed_origins": "none",
    "workers": "one per core, at least 2: reference entries leave a slot free",
    "metrics_token": "none: only this machine may read `/metrics`",
    "mail_url": "none: nothing is sent",
    "mail_from": "none",
    "oidc_issuer": "none",
    "oidc_client_id": "none",
    "oidc_client_secret": "none",
    "oidc_sign_up": "as `SEAMARK_SIGN_UP`",
}
# An address as browsers accept it in a form (HTML Living Standard, 4.10.5.1.5), with a domain.
MAIL_ADDRESS = r"[A-Za-z0-9.!#$%&'*+/=?^_`{|}~-]{1,64}@[A-Za-z0-9-]{1,63}(\.[A-Za-z0-9-]{1,63})*"

_ORIGIN = r"https?://[A-Za-z0-9.-]+(:\d{1,5})?"
_MAIL_HOST = r"[A-Za-z0-9.-]+(:\d{1,5})?"
_MAIL_USER = r"([^\s:@/]+:[^\s@/]+@)?"
_MAIL_URL = re.compile(
    rf"smtps://{_MAIL_USER}{_MAIL_HOST}|smtp://{_MAIL_USER}{_MAIL_HOST}(\?tls=starttls)?"
    rf"|smtp://{_MAIL_HOST}\?tls=none"
)


class KeyEmpty(Exception):
    """The file of a key is empty: what drew or wrote it has failed. The text says what to do."""


class SettingsInvalid(Exception):
    """A setting is unknown or has a wrong value. The text says which and what is allowed."""


class Settings(BaseModel):
    """Settings of an operator. Each field is the variable `SEAMARK_<NAME>` or `..._FILE`."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    # Not to be set: one number does for every installation.
    practice_trials_max: ClassVar[int] = 10
    run_max_bytes: ClassVar[int] = 256 * 2**20  # that a practice run may record
    attempts_max: ClassVar[int] = 3  # evaluations that break, until it is a platform failure
    streams_max: ClassVar[int] = 1000  # open event streams of a web process

    data: Path = Field(Path("data"), description="Folder for the database, uploads and results")
    database_url: str = Field("", description="sqlite:/// or postgresql:// URL of the database")
    broker_url: str = Field(
        "", description="redis:// or unix:// URL of Redis 7 or later, or Valkey"
    )
    secret_key: str = Field(
        "", repr=False, description="Signs cookies; you may change it at any time"
    )
    seed_key: str = Field(
        "", repr=False, description="Derives the seeds of ranked runs; never change it"
    )
    storage_url: str = Field(
        "",
        pattern=r"^(s3://[a-z0-9][a-z0-9.-]{1,61}[a-z0-9](/[A-Za-z0-9._/-]+)?|file:///.+)?$",
        description="Where runs and programs are kept: `s3://bucket/prefix`, or `file:///folder` "
        "of a disk that all machines share",
    )
    storage_endpoint: str = Field(
        "", pattern=rf"^({_ORIGIN})?$", description="Address of an S3 server other than Amazon's"
    )
    storage_region: str = Field("us-east-1", description="Region of the bucket")
    storage_access_key: str = Field(
        "", description="Access key of the bucket; without it, the machine's credentials"
    )
    storage_secret_key: str = Field("", repr=False, description="Secret of the access key")
    cache_bytes: int = Field(
        10 * 2**30,
        ge=2**20,
        description="Bytes that copies from the object storage may take on this machine",
    )
    public: bool = Field(False, description="The service is public")
    sandbox_min_level: LevelName = Field("medium", description="Lowest isolation level for uploads")
    host: str = Field("127.0.0.1", description="Address the web server listens on")
    port: int = Field(
        8000, ge=0, le=65535, description="Port the web server listens on; 0: any free port"
    )
    url: str = Field(
        "",
        pattern=rf"^({_ORIGIN})?$",
        description="Public address of the site, such as https://seamark.example: for the pictures "
        "of link previews, and for links in e-mails",
    )
    proxies: int = Field(
        0,
        ge=0,
        le=10,
        description="Trusted reverse proxies in front, which set X-Forwarded-For and -Proto",
    )
    embed_origins: str = Field(
        "",
        pattern=rf"^({_ORIGIN}( {_ORIGIN})*)?$",
        description="Other sites that may show runs in a frame: origins separated by spaces",
    )
    workers: int = Field(
        default_factory=lambda: max(len(os.sched_getaffinity(0)), 2),
        ge=1,
        le=512,
        description="Runs that one worker evaluates in parallel",
    )
    warm_boxes: int = Field(
        1, ge=0, le=64, description="Started boxes per language and slot that wait for programs"
    )
    bridge_places: int = Field(
        1,
        ge=0,
        le=64,
        description="Programs that may be connected to one worker by rosbridge at the same time, "
        "beside its runs; 0: none",
    )
    verify_top: int = Field(
        0,
        ge=0,
        le=100,
        description="How many of the first entries of each leaderboard are verified "
        "automatically: evaluated again on fresh trials, after the runs of users",
    )
    upload_max_bytes: int = Field(
        8 * 2**20, ge=1024, le=2**30, description="Maximum size of an upload"
    )
    quota_live: int = Field(5, ge=1, description="Runs a user may have queued or running")
    quota_day: int = Field(200, ge=1, description="Runs a user may complete in 24 h")
    ranked_day: int = Field(
        5, ge=1, description="Ranked runs a user may submit in 24 h, in each benchmark"
    )
    guest_quota_day: int = Field(
        50, ge=0, description="Runs that the guests of one network may complete in 24 h"
    )
    quota_bytes: int = Field(
        10 * 2**30, ge=2**20, description="Bytes that the runs of a user may take"
    )
    guest_quota_bytes: int = Field(
        2**30, ge=0, description="Bytes that the runs of the guests of one network may take"
    )
    free_min_bytes: int = Field(
        2**30,
        ge=0,
        description="Free bytes on the disk below which no new runs are accepted",
    )
    retention_days: int = Field(
        0, ge=0, description="Days after which the data of private runs are deleted; 0: never"
    )
    guest_retention_days: int = Field(
        90, ge=0, description="Days after which the data of guests' runs are deleted; 0: never"
    )
    retention_bytes: int = Field(
        0,
        ge=0,
        description="Bytes of all data beyond which the oldest of private practice runs are "
        "deleted; 0: no limit",
    )
    audit_days: int = Field(
        365, ge=1, le=3650, description="Days after which entries of the audit log are deleted"
    )
    running_max: int = Field(4, ge=1, description="Runs of one user that may run in parallel")
    lease_s: float = Field(
        30.0, gt=0, description="Time after which a silent worker loses its runs"
    )
    log_level: LogLevel = Field(
        "info", description="Least severe events in the log: `debug`, `info`, `warning` or `error`"
    )
    metrics_token: str = Field(
        "",
        repr=False,
        pattern=r"^([!-~]{20,200})?$",
        description="Token with which a Prometheus server reads `/metrics` from elsewhere; 20 "
        "characters or more",
    )
    sign_up: SignUp = Field(
        "open", description="Who may create an account: `open`, `invitation` or `closed`"
    )
    sign_ups_per_hour: int = Field(
        10, ge=1, description="Accounts per address and hour; a class often shares one"
    )
    mail_url: str = Field(
        "",
        repr=False,
        description="SMTP server that sends e-mail: `smtp://user:password@host:587`, `smtps://...`",
    )
    mail_from: str = Field(
        "",
        pattern=rf"^([^<>\"\x00-\x1f\x7f]{{1,80}} <{MAIL_ADDRESS}>|{MAIL_ADDRESS})?$",
        description="Sender of e-mails, such as `Seamark <seamark@example.org>`",
    )
    oidc_issuer: str = Field(
        "",
        pattern=rf"^({_ORIGIN}(/[A-Za-z0-9._~%/-]*)?)?$",
        max_length=300,
        description="Issuer of an OpenID Connect provider with which people may sign in",
    )
    oidc_client_id: str = Field("", description="Id of this service at the provider")
    oidc_client_secret: str = Field("", repr=False, description="Secret of this service there")
    oidc_name: str = Field(
        "single sign-on", max_length=40, description="Name of the provider on the pages"
    )
    oidc_sign_up: SignUp = Field(
        "open", description="Who may create an account here with the provider"
    )

    @field_validator("mail_url")
    @classmethod
    def _mail_url_is_known(cls, url: str) -> str:
        """Refuse an address without a known kind of TLS, and a password without TLS."""
        if url and not _MAIL_URL.fullmatch(url):
            raise ValueError(
                "write smtp://user:password@host:587 (STARTTLS), smtps://user:password@host:465 "
                "or, without a password, smtp://host:25?tls=none; %40 is @ in a password"
            )
        return url

    @model_validator(mode="before")
    @classmethod
    def _fill(cls, values: dict[str, object]) -> dict[str, object]:
        """Fill the defaults that follow from other fields."""
        filled = {key: value for key, value in values.items() if value != ""}
        data = Path(str(filled.get("data", "data"))).absolute()
        filled["data"] = data
        filled.setdefault("database_url", f"sqlite:///{data / 'seamark.db'}")
        filled.setdefault("oidc_sign_up", filled.get("sign_up", "open"))
        if str(filled.get("public", "")).lower() in {"1", "true", "yes", "on", "t", "y"}:
            filled.setdefault("sandbox_min_level", "strong")
        return filled

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        """Reject combinations that cannot work."""
        if self.mail_url and not (self.mail_from and self.url):
            raise ValueError("mail_url is set, so mail_from and url must be set: of what is sent")
        if self.oidc_issuer and not (self.oidc_client_id and self.oidc_client_secret and self.url):
            raise ValueError("oidc_issuer is set, so oidc_client_id, ..._secret and url must be")
        if self.public and self.oidc_issuer.startswith("http:"):
            raise ValueError("the oidc_issuer of a public service must be an https address")
        return self

    def model_post_init(self, context: object, /) -> None:
        """Read the keys that all processes of the service share; draw those that are missing.

        With `LOOKING` as context nothing is written: a key that is missing stays empty.
        """
        if context != LOOKING:
            self._draw_keys()
        for name, file in KEY_FILES.items():
            if not getattr(self, name) and (self.data / file).exists():
                object.__setattr__(self, name, kept(self.data / file))

    def _draw_keys(self) -> None:
        self.data.mkdir(parents=True, exist_ok=True, mode=0o700)
        secret = self.secret_key or kept(self.data / "secret", drawn())
        if secret == SIGNS_NOTHING:
            if not (self.seed_key or (self.data / "seed_key").exists()):
                object.__setattr__(self, "seed_key", DERIVES_NOTHING)
        elif not self.seed_key:
            kept(self.data / "seed_key", drawn())

    @property
    def heartbeat_s(self) -> float:
        """Interval at which a worker renews its leases."""
        return min(5.0, self.lease_s / 6)

    @property
    def sweep_s(self) -> float:
        """Interval at which runs of dead workers are recovered."""
        return min(10.0, self.lease_s / 3)

    @property
    def derives_seeds(self) -> bool:
        """Whether this process has the key from which the seeds of all ranked runs follow."""
        return self.seed_key not in {"", DERIVES_NOTHING}

    @classmethod
    def load(cls, environ: Mapping[str, str] | None = None, *, looking: bool = False) -> Self:
        """Return the settings of the environment; raises SettingsInvalid with a sentence each.

        Parameters
        ----------
        looking
            Write nothing: neither the data folder nor keys that are missing, which stay empty.
        """
        values = _values(os.environ if environ is None else environ)
        try:
            return cls.model_validate(values, context=LOOKING if looking else None)
        except ValidationError as wrong:
            raise SettingsInvalid("; ".join(_sentences(wrong))) from None
        except KeyEmpty as empty:
            raise SettingsInvalid(str(empty)) from None

    @classmethod
    def table(cls) -> str:
        """Return all settings as a Markdown table, for docs/hosting.md."""
        lines = ["| variable | default | meaning |", "|---|---|---|"]
        for name, field in cls.model_fields.items():
            default = DEFAULTS_IN_WORDS.get(name) or f"`{_shown(field.default)}`"
            lines.append(f"| `{PREFIX}{name.upper()}` | {default} | {field.description} |")
        return "\n".join(lines)

    def environment(self) -> dict[str, str]:
        """Return the variables from which a child process loads these same settings."""
        values = self.model_dump(mode="json")
        return {PREFIX + name.upper(): str(value) for name, value in values.items() if value != ""}


def _shown(default: object) -> str:
    """Return a default as one would write it into the environment."""
    return str(default).lower() if isinstance(default, bool) else str(default)


def _values(environ: Mapping[str, str]) -> dict[str, object]:
    values: dict[str, object] = {}
    for variable, text in sorted(environ.items()):
        if not variable.startswith(PREFIX):
            continue
        name, value = variable.removeprefix(PREFIX).lower(), text
        if name not in Settings.model_fields and name.endswith("_file"):
            name, value = name.removesuffix("_file"), _content(variable, text)
        if name not in Settings.model_fields:
            if name in REMOVED:
                raise SettingsInvalid(f"{variable} is no longer a setting: {REMOVED[name]}")
            raise SettingsInvalid(f"{variable} is not a setting of Seamark")
        if name in values:
            raise SettingsInvalid(f"{PREFIX}{name.upper()} is given twice, directly and as a file")
        # Nobody means an empty secret: what draws or writes it has failed.
        if not value.strip() and not Settings.model_fields[name].repr:
            raise SettingsInvalid(f"{variable} is empty. Give it a value, or leave it out")
        values[name] = value
    return values


def _content(variable: str, path: str) -> str:
    try:
        content = Path(path).read_text(encoding="utf-8").strip()
    except OSError as error:
        raise SettingsInvalid(f"{variable}: {path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SettingsInvalid(f"{variable}: {path} is no text") from None
    if not content:
        raise SettingsInvalid(
            f"{variable}: {path} is empty. Write the value into it, or leave the variable out"
        )
    return content


def _sentences(wrong: ValidationError) -> list[str]:
    return [
        f"{PREFIX}{'_'.join(str(part) for part in error['loc']).upper() or '*'}: {error['msg']}"
        for error in wrong.errors()
    ]


def drawn() -> str:
    """Return a new key."""
    return secrets.token_urlsafe(48)


def kept(path: Path, first: str = "") -> str:
    """Return the key in a file, which gets `first` if it is not there. Race-free."""
    if not path.exists():
        draft = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
        with open(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(first)
            file.flush()
            os.fsync(file.fileno())  # else a power cut could leave an empty file
        try:
            os.link(draft, path)  # fails if another process was faster: then its key counts
        except FileExistsError:
            pass
        finally:
            draft.unlink()
    key = path.read_text(encoding="utf-8").strip()
    if not key:
        raise KeyEmpty(f"{path} is empty. {_WITHOUT[path.name]}")
    return key
