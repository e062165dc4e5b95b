"""Compressed responses, and what all files of each page take on the wire."""

import re
import zlib
from pathlib import PurePosixPath
from urllib.parse import urljoin, urlsplit

import pytest
from flask.testing import FlaskClient

from tests.server.api.conftest import Site

GZIP = {"Accept-Encoding": "gzip"}
PAGE_MAX = 300 * 1024  # [byte] of a page with all that it loads, without three.js
_LOADED = re.compile(r'<(?:script|link|img)[^>]* (?:src|href)="([^"]+)"')
_IMPORTED = re.compile(r'^(?:import|export) [^;]*?["\'](\.[^"\']+)["\'];', re.MULTILINE)
_PAGES = (
    *("/", "/submit/currents-v1", "/submit/visibility-v2", "/benchmarks/currents-v2", "/runs/"),
    *("/leaderboards/currents-v1", "/sign-in", "/sign-up", "/tokens", "/status", "/api/docs"),
    *("/docs/start", "/docs/controller", "/docs/physics", "/docs/guides/benchmarks.md"),
    *("/docs/guides/ranking.md", "/problems", "/runs/{run}", "/runs/{run}/embed"),
    *("/compare?runs={run}", "/compare?runs={run},{other}"),
)


def _unzipped(data: bytes) -> bytes:
    return zlib.decompress(data, zlib.MAX_WBITS | 16)


def test_telemetry_is_compressed_if_the_client_accepts_it(site: Site) -> None:
    path = f"/api/v1/runs/{site.recorded()}/telemetry.csv"

    plain = site.call("owner", "GET", path)
    gzipped = site.call("owner", "GET", path, headers=GZIP)
    refused = site.call("owner", "GET", path, headers={"Accept-Encoding": "gzip;q=0, *;q=0"})

    assert "Content-Encoding" not in plain.headers
    assert gzipped.headers["Content-Encoding"] == "gzip"
    assert "Content-Encoding" not in refused.headers
    assert _unzipped(gzipped.data) == refused.data == plain.data
    assert len(gzipped.data) < 0.5 * len(plain.data)
    assert "Accept-Encoding" in gzipped.headers["Vary"]
    assert gzipped.headers["X-Next-Row"] == plain.headers["X-Next-Row"]


def test_a_client_that_has_a_compressed_response_gets_it_confirmed(site: Site) -> None:
    path = f"/api/v1/runs/{site.recorded()}"

    plain = site.call("owner", "GET", path)
    gzipped = site.call("owner", "GET", path, headers=GZIP)
    tag = gzipped.headers["ETag"]
    again = site.call("owner", "GET", path, headers=GZIP | {"If-None-Match": tag})

    assert tag == f"W/{plain.headers['ETag']}"
    assert again.status_code == 304
    assert _unzipped(gzipped.data) == plain.data


def test_a_range_is_of_the_file_as_it_is_stored(site: Site) -> None:
    path = "/static/vendor/uplot/uPlot.iife.min.js"
    client = site.client()

    with client.get(path) as whole, client.get(path, headers=GZIP | {"Range": "bytes=10-19"}) as it:
        assert (it.status_code, it.data) == (206, whole.data[10:20])
        assert "Content-Encoding" not in it.headers
        etag = it.headers["ETag"]
    with client.get(path, headers={"Range": "bytes=0-4", "If-Range": etag}) as same:
        assert (same.status_code, same.data) == (206, whole.data[:5])


@pytest.mark.parametrize("name", ["camera.jpg?trial=0&t=1", "dataset.zip"])
def test_what_is_compressed_already_stays_as_it_is(site: Site, name: str) -> None:
    run_id = site.recorded()

    with site.call("owner", "GET", f"/api/v1/runs/{run_id}/{name}", headers=GZIP) as answer:
        assert answer.status_code == 200
        assert "Content-Encoding" not in answer.headers


def _wire_sizes(client: FlaskClient, page: str, headers: dict[str, str]) -> dict[str, int]:
    """Return the sizes of a page and of all that it loads, as they are sent with gzip."""
    sizes: dict[str, int] = {}
    waiting = [page]
    while waiting:
        path = waiting.pop()
        if path in sizes or PurePosixPath(path).name.startswith("three."):
            continue
        with client.get(path, headers=headers | GZIP) as answer:
            assert answer.status_code == 200, path
            sizes[path] = len(answer.data)
            gzipped = answer.headers.get("Content-Encoding") == "gzip"
            text = (_unzipped(answer.data) if gzipped else answer.data).decode("utf-8", "replace")
        found = _LOADED.findall(text) if path == page else ()
        if path.endswith(".js"):
            found = _IMPORTED.findall(text)
        waiting += [urljoin(path, each) for each in found if _is_own_file(each)]
    return sizes


def _is_own_file(address: str) -> bool:
    return not urlsplit(address).netloc and (address.startswith(("/static/", ".")))


@pytest.mark.slow
def test_every_page_is_small(site: Site) -> None:
    run_id, other = site.recorded(), site.recorded()

    sizes = {
        path: sum(_wire_sizes(site.client(), path, site.headers["owner"]).values())
        for path in (page.format(run=run_id, other=other) for page in _PAGES)
    }

    assert {path: size for path, size in sizes.items() if size > PAGE_MAX} == {}
    assert min(sizes.values()) > 5 * 1024


def test_the_size_of_a_page_counts_its_scripts_and_what_they_import(site: Site) -> None:
    run_id, other = site.recorded(), site.recorded()
    path = f"/compare?runs={run_id},{other}"

    loaded = _wire_sizes(site.client(), path, site.headers["owner"])

    assert {
        "js/compare/main.js",
        "js/player/playhead.js",
        "js/player/colours.js",
        "vendor/uplot/uPlot.iife.min.js",
        "css/base.css",
    } <= {path.split("/", 3)[-1] for path in loaded}
