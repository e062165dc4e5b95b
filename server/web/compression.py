"""Responses compressed with gzip for clients that accept it: pages, scripts, JSON and CSV."""

import gzip
import zlib
from collections.abc import Iterable, Iterator

from flask import Flask, Response, request
from werkzeug.wsgi import ClosingIterator

# Takes less time than writing telemetry as CSV; level 6 takes three times as long for 3 % less.
LEVEL = 4
SIZE_MIN = 500  # [byte]: less does not become fewer packets
# Images and archives are compressed already; a stream of events must not wait in a buffer.
MEDIA_TYPES = frozenset(
    {
        *("text/html", "text/css", "text/javascript", "text/csv", "text/plain"),
        *("application/json", "application/problem+json", "image/svg+xml"),
    }
)
_GZIP_BITS = zlib.MAX_WBITS | 16  # with the header of gzip


def register(app: Flask) -> None:
    """Compress the responses of all routes."""
    app.after_request(_compress)


def _compress(response: Response) -> Response:
    if response.mimetype not in MEDIA_TYPES:
        return response
    response.vary.add("Accept-Encoding")
    if not _is_wanted(response):
        return response
    response.headers["Content-Encoding"] = "gzip"
    etag, is_weak = response.get_etag()
    if etag is not None and not is_weak:
        # Still enough for If-None-Match; a range must not be of the compressed bytes.
        response.set_etag(etag, weak=True)
    if response.is_sequence:
        response.set_data(gzip.compress(response.get_data(), LEVEL, mtime=0))
        return response
    # A stream stays one: neither the text nor the compressed bytes are ever in memory as a whole.
    body = response.response
    response.direct_passthrough = False
    pieces = _gzipped(response.iter_encoded())
    response.response = ClosingIterator(pieces, getattr(body, "close", None))
    response.headers.pop("Content-Length", None)
    return response


def _is_wanted(response: Response) -> bool:
    if response.status_code == 206 or "Range" in request.headers:
        return False  # a range counts the bytes of the file
    if "Content-Encoding" in response.headers or response.status_code == 304:
        return False
    length = response.content_length
    return (length is None or length >= SIZE_MIN) and request.accept_encodings["gzip"] > 0


def _gzipped(pieces: Iterable[bytes]) -> Iterator[bytes]:
    compressor = zlib.compressobj(LEVEL, zlib.DEFLATED, _GZIP_BITS)
    for piece in pieces:
        if compressed := compressor.compress(piece):
            yield compressed
    yield compressor.flush()
