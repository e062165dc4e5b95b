"""Compiled code stays beside the sources of a checkout and out of an installed package."""

import os
from pathlib import Path

import pytest

from seamark.sim.numerics.cache_folder import cache_folder


def test_a_checkout_keeps_its_compiled_code_beside_the_sources(tmp_path: Path) -> None:
    assert cache_folder(tmp_path, {"XDG_CACHE_HOME": "/elsewhere"}) == tmp_path


@pytest.mark.parametrize("folder", ["lib/python3.11/site-packages", "python3/dist-packages"])
def test_an_installed_package_keeps_it_in_the_cache_folder_of_the_user(
    tmp_path: Path, folder: str
) -> None:
    installed = tmp_path / folder / "seamark" / "sim"
    installed.mkdir(parents=True)

    assert cache_folder(installed, {"XDG_CACHE_HOME": "/big/cache"}) == Path("/big/cache/seamark")
    assert cache_folder(installed, {}) == Path.home() / ".cache" / "seamark"


def test_sources_that_cannot_be_written_to_keep_it_in_the_cache_folder_of_the_user(
    tmp_path: Path,
) -> None:
    absent = tmp_path / "absent"  # root may write to any folder that exists

    assert not os.access(absent, os.W_OK)
    assert cache_folder(absent, {"XDG_CACHE_HOME": "/big"}) == Path("/big/seamark")


def test_a_relative_cache_folder_is_ignored(tmp_path: Path) -> None:
    absent = tmp_path / "absent"

    folder = cache_folder(absent, {"XDG_CACHE_HOME": "cache"})

    assert folder == Path.home() / ".cache" / "seamark"
