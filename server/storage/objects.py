"""Object storage: what the machines of a service share instead of a disk.

With `SEAMARK_STORAGE_URL` the objects are the truth, and folders of the machines hold copies;
without it the data folder itself is the truth, and none of this is used. The library's threads do
not survive a fork: only processes that do not fork afterwards may ask for objects.
"""

import math
import os
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import timedelta
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import obstore
from obstore.exceptions import BaseError
from obstore.store import LocalStore, S3Store

from seamark.server.settings import Settings

if TYPE_CHECKING:
    from obstore.store import ClientConfig, RetryConfig, S3Config

MARK = "seamark-data"  # its content tells the storage of one service from that of another
PROBE_S = 5.0  # between two looks whether the storage answers
ANSWER_S = 1.0  # that somebody waits who wants to know whether it does
REQUEST = timedelta(seconds=60)  # one that writes; a piece of a large file
SILENCE = timedelta(seconds=10)  # of a storage that is read: somebody waits for what it says
_PROBE = timedelta(seconds=3)
_CONNECT = timedelta(seconds=5)
_RETRY: "RetryConfig" = {"max_retries": 3, "retry_timeout": timedelta(seconds=10)}
_PROBE_RETRY: "RetryConfig" = {"max_retries": 1, "retry_timeout": timedelta(seconds=10)}


class ObjectsAway(Exception):
    """The object storage does not answer, or refuses. The text says why, for the log."""


@dataclass(frozen=True, slots=True)
class Object:
    """An object as a listing shows it."""

    path: str
    size: int  # [B]
    changed_at: float  # [s] by the clock of the storage
    tag: str  # differs when the content does


_Store = S3Store | LocalStore


class _Probe:
    """Whether a storage answers: it is asked in a thread, so that nobody waits for one that hangs.

    `asked` may take its time; who wants to know gets what it found last, if that is not old.
    """

    def __init__(self, asked: Callable[[], bool]) -> None:
        self._asked = asked
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._answer, self._answered_at = False, -math.inf

    def answer(self) -> bool:
        """Return what was found, at most two periods ago; False if nothing was."""
        with self._lock:
            if self._thread is None and self._age_s() >= PROBE_S:
                self._thread = threading.Thread(target=self._ask, name="probe", daemon=True)
                self._thread.start()
            thread = self._thread
        if thread is not None and self._age_s() >= 2 * PROBE_S:
            thread.join(ANSWER_S)
        return self._answer and self._age_s() < 2 * PROBE_S

    def _age_s(self) -> float:
        return time.monotonic() - self._answered_at

    def _ask(self) -> None:
        answer = False
        try:
            answer = self._asked()
        finally:  # whatever it was: the next one looks again
            with self._lock:
                self._answer, self._answered_at, self._thread = answer, time.monotonic(), None


class Objects:
    """The objects of one service. Every method raises ObjectsAway.

    Parameters
    ----------
    store
        For what is written.
    reader, prober
        The same storage with shorter limits, for those who wait for what they read, and for the
        question whether it answers.
    """

    def __init__(
        self, store: _Store, *, reader: _Store | None = None, prober: _Store | None = None
    ) -> None:
        self._store, self._reader, self._prober = store, reader or store, prober or store
        self._probe = _Probe(self._is_marked)

    def put(self, path: str, content: bytes | Path) -> None:
        """Store an object; a file is read piece by piece."""
        try:
            obstore.put(self._store, path, content)
        except (BaseError, OSError) as error:
            raise _away(error) from error

    def copy(self, path: str, target: str) -> None:
        """Store an object under another path as well; its content stays in the storage."""
        try:
            obstore.copy(self._store, path, target)
        except (BaseError, OSError) as error:
            raise _away(error) from error

    def get(self, path: str) -> bytes | None:
        """Return the content of a small object; None if there is none."""
        try:
            return bytes(obstore.get(self._reader, path).bytes())
        except FileNotFoundError:
            return None
        except (BaseError, OSError) as error:
            raise _away(error) from error

    def fetch(self, path: str, target: Path) -> bool:
        """Copy an object into a file, all of it or nothing; False if there is no such object."""
        draft = target.with_name(f".{target.name}.{os.getpid()}-{threading.get_ident()}")
        try:
            with draft.open("wb") as file:
                for piece in obstore.get(self._reader, path):
                    file.write(piece)
            draft.replace(target)
        except FileNotFoundError:
            return False
        except (BaseError, OSError) as error:
            raise _away(error) from error
        finally:
            draft.unlink(missing_ok=True)
        return True

    def size(self, path: str) -> int | None:
        """Return the size of an object [B]; None if there is none."""
        stored = self.find(path)
        return None if stored is None else stored.size

    def find(self, path: str) -> Object | None:
        """Return what a listing would show of an object; None if there is none."""
        try:
            return _object(obstore.head(self._reader, path))
        except FileNotFoundError:
            return None
        except (BaseError, OSError) as error:
            raise _away(error) from error

    def list(self, folder: str) -> Sequence[Object]:
        """Return all objects of a folder and the folders below it, in order of their paths."""
        try:
            objects = [_object(one) for page in obstore.list(self._reader, folder) for one in page]
        except (BaseError, OSError) as error:
            raise _away(error) from error
        return sorted(objects, key=lambda one: one.path)

    def folders(self, folder: str) -> Sequence[str]:
        """Return the names of the folders in a folder."""
        try:
            listing = obstore.list_with_delimiter(self._reader, folder)
        except (BaseError, OSError) as error:
            raise _away(error) from error
        return [path.rpartition("/")[2] for path in listing["common_prefixes"]]

    def delete(self, paths: Sequence[str]) -> None:
        """Delete objects; those that are gone already are no error."""
        try:
            if paths:
                obstore.delete(self._reader, list(paths))
        except FileNotFoundError:
            pass
        except (BaseError, OSError) as error:
            raise _away(error) from error

    def answers(self) -> bool:
        """Return whether the storage answers and is that of a service, without waiting long."""
        return self._probe.answer()

    def _is_marked(self) -> bool:
        try:
            obstore.head(self._prober, MARK)
        except (BaseError, OSError):
            return False
        return True


class _Location(NamedTuple):
    url: str
    endpoint: str
    region: str
    access_key: str
    secret_key: str


def of(settings: Settings) -> Objects | None:
    """Return the object storage of a service; None if its data folder is the truth."""
    if not settings.storage_url:
        return None
    return _opened(
        _Location(
            settings.storage_url.rstrip("/"),
            settings.storage_endpoint,
            settings.storage_region,
            settings.storage_access_key,
            settings.storage_secret_key,
        )
    )


@cache
def _opened(location: _Location) -> Objects:
    if location.url.startswith("file://"):
        return Objects(LocalStore(location.url.removeprefix("file://"), mkdir=True))
    bucket, _, prefix = location.url.removeprefix("s3://").partition("/")
    # What is empty here comes from the machine: AWS_... variables or the role of an instance.
    chosen: S3Config = {"region": location.region}
    if location.endpoint:
        chosen["endpoint"] = location.endpoint
    if location.access_key:
        chosen["access_key_id"] = location.access_key
        chosen["secret_access_key"] = location.secret_key
    client: ClientConfig = {
        "timeout": REQUEST,
        "connect_timeout": _CONNECT,
        "allow_http": location.endpoint.startswith("http://"),
    }

    def opened(limits: "ClientConfig", retry: "RetryConfig") -> S3Store:
        options: ClientConfig = {**client, **limits}
        return S3Store(
            bucket,
            prefix=prefix or None,
            client_options=options,
            retry_config=retry,
            config=chosen,
        )

    return Objects(
        opened({}, _RETRY),
        reader=opened({"read_timeout": SILENCE}, _RETRY),
        prober=opened({"timeout": _PROBE}, _PROBE_RETRY),
    )


def _object(meta: "obstore.ObjectMeta") -> Object:
    return Object(
        meta["path"], meta["size"], meta["last_modified"].timestamp(), meta["e_tag"] or ""
    )


def _away(error: Exception) -> ObjectsAway:
    return ObjectsAway(str(error).partition("\n")[0])
