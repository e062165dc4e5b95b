"""Plain Parquet, as Polars reads it."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import polars
import pytest

from tests.seamark.demonstrations.replay import replayed

Written = Callable[..., Path]
pytestmark = pytest.mark.slow  # all simulate


def test_a_row_has_an_observation_and_what_the_expert_did_then(written_once: Written) -> None:
    folder = written_once("parquet")
    steps = polars.read_parquet(folder / "steps" / "**" / "*.parquet")
    compared = 0

    for about in polars.read_parquet(folder / "episodes.parquet").iter_rows(named=True):
        rows = steps.filter(polars.col("episode") == about["episode"])
        *acting, last = rows.iter_rows(named=True)
        actions = np.array([row["action"] for row in acting])
        newest: dict[str, bytes] = {}
        again = replayed(folder, about["seed"], about["level"], actions)
        for at, (row, step) in enumerate(zip((*acting, last), again, strict=True)):
            assert row["step"] == at
            np.testing.assert_array_equal(row["observation"], step.observation["state"])
            for camera in ("vehicle", "arm"):
                newest[camera] = row[f"image_{camera}"] or newest[camera]
                png = np.frombuffer(newest[camera], np.uint8)
                image = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
                np.testing.assert_array_equal(image, step.observation[f"image_{camera}"])
            compared += 1
        assert about["steps"] == len(acting) == 40
        assert about["credit"] == last["credit"]
        assert (last["action"], last["reward"]) == (None, None)
        assert [row["truncated"] for row in acting] == [False] * 39 + [True]

    assert compared == 3 * 41
    assert steps["image_arm"].null_count() > 0.4 * len(steps)  # ten images a second, 20 steps
