"""The manifest says what a result was made of, in plain JSON."""

import json

from seamark.sim.recording.manifest import code_sha256, cpu_class, manifest, versions
from seamark.sim.registry import benchmark


def test_the_manifest_is_json_and_brings_the_configuration_back() -> None:
    currents = benchmark("currents-v1")
    config = currents.read({"kp": 0.3, "levels": [0.1]})

    made = manifest("currents-v1", config, seed=5, trials=1, controller="pi", digest="00", run=17)

    assert json.loads(json.dumps(made, allow_nan=False)) == made
    assert currents.read(made["configuration"]) == config
    assert (made["seed"], made["digest"], made["run"]) == (5, "00", 17)
    assert made["contacts"] == "seamark"


def test_the_code_has_one_hash_and_the_libraries_have_versions() -> None:
    assert len(code_sha256()) == 64
    assert {"python", "numpy", "numba", "pybullet"} <= set(versions())
    assert all(versions().values())
    assert set(cpu_class()) == {"machine", "level", "model"}


def test_a_tracker_that_depends_on_the_processor_is_named_in_the_manifest() -> None:
    currents = benchmark("currents-v1")

    made = [
        manifest(
            "currents-v1",
            currents.read({"tracker": name}),
            seed=5,
            trials=1,
            controller="pi",
            digest="00",
        )
        for name in ("esm", "ecc")
    ]

    assert [entry["same_bits_on_every_cpu"] for entry in made] == [True, False]


def test_an_uploaded_program_may_depend_on_the_processor() -> None:
    config = benchmark("currents-v1").read({})

    made = manifest(
        "currents-v1",
        config,
        seed=5,
        trials=1,
        controller="upload",
        program_sha256="ab" * 32,
        digest="00",
    )

    assert config.exact()
    assert made["same_bits_on_every_cpu"] is False
