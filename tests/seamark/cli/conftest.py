"""Results of local runs."""

from pathlib import Path

import pytest

from seamark.cli.configuration import configuration_of
from seamark.cli.output_folder import OutputFolder
from seamark.worker.evaluation.local import Callbacks, evaluate_locally

SHORT = ("levels=0,0.3", "level_duration_s=4", "settle_s=1")


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results `pi` and `p` of three trials in the same conditions."""
    folder = tmp_path_factory.mktemp("results")
    config = configuration_of("currents-v1", None, SHORT).model_dump(mode="json")
    for name in ("pi", "p"):
        output = OutputFolder(folder / name)
        outcome = evaluate_locally(
            "currents-v1",
            config,
            seed=7,
            trials=3,
            controller=name,
            callbacks=Callbacks(rows=output.add_rows),
            processes=1,
        )
        output.save("currents-v1", outcome)
    return folder
