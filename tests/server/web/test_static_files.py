"""Files of the pages are asked for once, and again when one of them has changed."""

import re
from pathlib import Path

import pytest
from flask import Flask, url_for

from seamark.server.web import static_files

FOREVER = "max-age=31536000"


def _served(folder: Path) -> Flask:
    app = Flask("served", static_folder=None)
    static_files.register(app, folder)
    return app


def _address(app: Flask, filename: str) -> str:
    with app.test_request_context():
        return url_for("static", filename=filename)


def _cached(app: Flask, path: str) -> str:
    with app.test_client().get(path) as answer:
        assert answer.status_code == 200, path
        return answer.headers["Cache-Control"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two scripts, one of which imports the other."""
    folder = tmp_path / "static"
    (folder / "js").mkdir(parents=True)
    (folder / "js" / "one.js").write_text('import "./two.js";')
    (folder / "js" / "two.js").write_text("export {};")
    return folder


def test_a_browser_keeps_a_file_and_what_it_imports_for_good(folder: Path) -> None:
    app = _served(folder)
    address = _address(app, "js/one.js")

    kept = [_cached(app, address), _cached(app, address.replace("one", "two"))]

    assert address.endswith("/js/one.js")
    for each in kept:
        assert {"public", "immutable", FOREVER} == set(each.split(", "))


def test_every_address_changes_with_one_file_and_with_its_name(folder: Path) -> None:
    seen = [_address(_served(folder), "js/one.js")]
    (folder / "js" / "two.js").write_text("export const two = 2;")
    static_files._version_of.cache_clear()
    seen.append(_address(_served(folder), "js/one.js"))
    (folder / "js" / "two.js").rename(folder / "js" / "three.js")
    static_files._version_of.cache_clear()
    seen.append(_address(_served(folder), "js/one.js"))

    assert len(set(seen)) == 3


def test_a_page_from_before_an_upgrade_still_gets_files_but_does_not_keep_them(
    folder: Path,
) -> None:
    app = _served(folder)
    old = re.sub(r"[0-9a-f]{16}", "0" * 16, _address(app, "js/one.js"))

    assert [_cached(app, path) for path in (old, "/static/js/one.js")] == ["no-cache"] * 2


@pytest.mark.parametrize("path", ["../secret", "{version}/../secret", "{version}/", "js"])
def test_nothing_but_the_files_of_the_folder_is_served(folder: Path, path: str) -> None:
    (folder.parent / "secret").write_text("s")
    app = _served(folder)
    version = _address(app, "x").split("/")[2]

    answer = app.test_client().get("/static/" + path.format(version=version))

    assert answer.status_code == 404
