"""Connections to one server: what requests carry, and doing what calls yield."""

from __future__ import annotations

import asyncio
import os
import ssl
import time
from collections.abc import Mapping
from typing import Any, BinaryIO, Final, TypeVar

import httpx

from seamark.client import exchange
from seamark.client.calls import Calls
from seamark.client.exchange import Answer, Call, Pause, Request

DEFAULT_SERVER: Final = "http://127.0.0.1:8000"
SERVER_VARIABLE: Final = "SEAMARK_SERVER"
TOKEN_VARIABLE: Final = "SEAMARK_TOKEN"  # noqa: S105 (the name of a variable)
TIMEOUT_S = 30.0  # until an answer starts or goes on
PATIENCE_S = 60.0  # of all pauses before a request is given up
# Trusts nobody: a server without TLS needs no certificates, and no redirect leads to another one.
# To read the usual ones takes 30 ms.
NO_CERTIFICATES: Final = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)

Result = TypeVar("Result")


class Connection:
    """The address and the token of a server, and its calls.

    Parameters
    ----------
    server
        Its address; SEAMARK_SERVER if None, else http://127.0.0.1:8000.
    token
        API token of an account; SEAMARK_TOKEN if None. Without one, a guest.
    patience_s
        How long the pauses between the attempts of one request may last in total [s].
    """

    def __init__(self, server: str | None, token: str | None, *, patience_s: float) -> None:
        self.server = (server or os.environ.get(SERVER_VARIABLE) or DEFAULT_SERVER).rstrip("/")
        self._token = token or os.environ.get(TOKEN_VARIABLE) or None
        self.calls = Calls(self.server, signed_in=self._token is not None, patience_s=patience_s)

    def _http_options(self) -> Mapping[str, Any]:
        """Return how httpx is set up."""
        headers = {"Accept": "application/json", "User-Agent": "seamark"}
        if self._token:
            headers["Authorization"] = f"Bearer {self._token}"
        plain = self.server.lower().startswith("http://")
        return {
            "base_url": self.server,
            "headers": headers,
            "timeout": TIMEOUT_S,
            "verify": NO_CERTIFICATES if plain else True,
        }


class Session(Connection):
    """A connection that blocks while it waits."""

    def __init__(
        self,
        server: str | None,
        token: str | None,
        *,
        patience_s: float,
        transport: httpx.BaseTransport | None,
    ) -> None:
        super().__init__(server, token, patience_s=patience_s)
        self._http = httpx.Client(**self._http_options(), transport=transport)

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def do(self, call: Call[Result]) -> Result:
        """Return the result of a call, doing what it yields."""
        answer: Answer = None
        try:
            while True:
                answer = self._perform(exchange.advance(call, answer))
        except StopIteration as done:
            result: Result = done.value
            return result

    def _perform(self, wanted: Request | Pause) -> Answer:
        if isinstance(wanted, Pause):
            time.sleep(wanted.seconds)
            return None
        try:
            if wanted.into is not None:
                return self._download(wanted, wanted.into)
            return self._http.request(wanted.method, wanted.path, **wanted.options)
        except (httpx.HTTPError, httpx.InvalidURL) as error:
            return error

    def _download(self, wanted: Request, into: BinaryIO) -> httpx.Response:
        with self._http.stream(wanted.method, wanted.path, **wanted.options) as response:
            if response.is_success:
                _start_again(into)
                for piece in response.iter_bytes():
                    into.write(piece)
            else:
                response.read()
        return response


class AsyncSession(Connection):
    """A connection for asyncio."""

    def __init__(
        self,
        server: str | None,
        token: str | None,
        *,
        patience_s: float,
        transport: httpx.AsyncBaseTransport | None,
    ) -> None:
        super().__init__(server, token, patience_s=patience_s)
        self._http = httpx.AsyncClient(**self._http_options(), transport=transport)

    async def close(self) -> None:
        """Close the connections."""
        await self._http.aclose()

    async def do(self, call: Call[Result]) -> Result:
        """Return the result of a call, doing what it yields."""
        answer: Answer = None
        try:
            while True:
                answer = await self._perform(exchange.advance(call, answer))
        except StopIteration as done:
            result: Result = done.value
            return result

    async def _perform(self, wanted: Request | Pause) -> Answer:
        if isinstance(wanted, Pause):
            await asyncio.sleep(wanted.seconds)
            return None
        try:
            if wanted.into is not None:
                return await self._download(wanted, wanted.into)
            return await self._http.request(wanted.method, wanted.path, **wanted.options)
        except (httpx.HTTPError, httpx.InvalidURL) as error:
            return error

    async def _download(self, wanted: Request, into: BinaryIO) -> httpx.Response:
        async with self._http.stream(wanted.method, wanted.path, **wanted.options) as response:
            if response.is_success:
                _start_again(into)
                async for piece in response.aiter_bytes():
                    into.write(piece)
            else:
                await response.aread()
        return response


def _start_again(into: BinaryIO) -> None:
    """Forget what an attempt before this one has written."""
    into.seek(0)
    into.truncate()
