"""Internals of Numba are all there; with another version stale code is never used."""

import subprocess
import sys
import tomllib
from pathlib import Path

import numba
import pytest
from numba.core.caching import _CacheLocator

from seamark.sim.numerics.compiled_cache import START_INTERNALS, SourceStampLocator
from seamark.sim.numerics.late_bitcode import BITCODE_INTERNALS
from seamark.sim.numerics.numba_internals import (
    CACHE_INTERNALS,
    CALL_INTERNALS,
    LOCATORS,
    SIMD_INTERNALS,
    TESTED_NUMBA,
    configure_cache,
    missing,
)
from tests.services.prepared import printed

PYPROJECT = Path(__file__).parents[3] / "pyproject.toml"


# A process that has loaded all that runs need multiplies by BLAS.
WARM = """
import sys

print("scipy.linalg" in sys.modules)

import numba
import numpy as np

print(numba.njit(lambda a, b: a @ b)(np.eye(2), np.ones(2)).tolist())
"""


@pytest.mark.parametrize(
    "internal",
    CACHE_INTERNALS + CALL_INTERNALS + SIMD_INTERNALS + START_INTERNALS + BITCODE_INTERNALS,
)
def test_the_installed_numba_has_every_internal_that_the_simulator_uses(internal: str) -> None:
    assert not missing([internal]), f"Numba {numba.__version__} no longer has {internal}"


@pytest.mark.slow
@pytest.mark.timeout(1200)  # the very first start compiles the simulator
def test_no_function_of_the_simulator_loads_linear_algebra_and_those_of_others_still_can() -> None:
    assert printed(WARM, on="warm").splitlines() == ["False", "[1.0, 1.0]"]


def test_the_pin_of_numba_is_the_tested_minor_version() -> None:
    pins = tomllib.loads(PYPROJECT.read_text("utf-8"))["project"]["dependencies"]

    major, minor = map(int, TESTED_NUMBA.split("."))
    assert f"numba>={major}.{minor},<{major}.{minor + 1}" in pins
    assert numba.__version__.startswith(f"{TESTED_NUMBA}.")


def test_the_locator_has_every_method_that_numba_requires() -> None:
    required = set(_CacheLocator.__abstractmethods__) | {"from_function", "ensure_cache_path"}

    assert not {name for name in required if not callable(getattr(SourceStampLocator, name, None))}


def test_the_tested_numba_gets_the_locator_by_the_stamp_of_the_sources() -> None:
    environ: dict[str, str] = {}

    configure_cache(environ, f"{TESTED_NUMBA}.9")

    assert environ == {"NUMBA_CACHE_LOCATOR_CLASSES": LOCATORS}


def test_another_numba_gets_a_folder_for_the_state_of_all_sources_and_a_warning(
    tmp_path: Path,
) -> None:
    environ = {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_CACHE_LOCATOR_CLASSES": LOCATORS}

    with pytest.warns(RuntimeWarning, match=f"9.0.0 is not the tested version {TESTED_NUMBA}"):
        configure_cache(environ, "9.0.0")
    inherited = dict(environ)
    with pytest.warns(RuntimeWarning, match="not the tested version"):
        configure_cache(inherited, "9.0.0")

    folder = Path(environ["NUMBA_CACHE_DIR"])
    assert folder.parent == tmp_path
    assert folder != tmp_path
    assert inherited == environ
    assert "NUMBA_CACHE_LOCATOR_CLASSES" not in environ


@pytest.mark.slow
def test_without_an_internal_the_vectors_refuse_to_load_and_name_the_version() -> None:
    code = (
        "import numba.core.cgutils as internals\n"
        "del internals.get_or_insert_function\n"
        "import seamark.sim.numerics.simd\n"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.returncode == 1
    assert f"The simulator needs Numba {TESTED_NUMBA}" in done.stderr
    assert "numba.core.cgutils:get_or_insert_function" in done.stderr
