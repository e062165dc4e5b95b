"""Train a controller with PyTorch and pack it, as a network in ONNX's format, to be submitted.

    pip install "seamark[box]" torch onnx onnxscript
    python examples/torch_to_onnx.py --out onnx_controller.zip
    seamark run currents-v1 --controller onnx_controller.zip

The network learns to imitate a P controller with limits, within seconds: put your own training into
`trained`. The archive has the network and main.py, which runs it with ONNX Runtime; a sandbox has
that, and no PyTorch. Networks of JAX take the same way: jax2onnx or tf2onnx export them.
"""

import argparse
import io
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

CONTROLLER = '''"""Runs the network of policy.onnx, which lies beside this file in the archive."""

import numpy as np
import onnxruntime


class Controller:
    def __init__(self, config):
        self.network = onnxruntime.InferenceSession("policy.onnx")

    def step(self, observation):
        error = np.asarray(observation.error, np.float32)[None]
        surge, sway, heave = self.network.run(None, {"error": error})[0][0]
        return surge, sway, heave, 0.0
'''
GAIN, SPEED_MAX = 0.5, 1.0  # 1/s, m/s: of the controller that the network imitates
HIDDEN = 32
STEPS, BATCH, WIDEST = 2000, 256, 4.0  # of the training; the largest error [m]


def imitated(error: np.ndarray) -> np.ndarray:
    """Return the command to errors [m], as velocities along the axes of the body [m/s]."""
    return np.clip(GAIN * error, -SPEED_MAX, SPEED_MAX)


def trained(steps: int) -> Any:
    """Return a network that has learned from random errors."""
    import torch  # noqa: PLC0415 - to pack a network needs no PyTorch

    torch.manual_seed(1)
    random = np.random.default_rng(1)
    network = torch.nn.Sequential(
        torch.nn.Linear(3, HIDDEN), torch.nn.Tanh(), torch.nn.Linear(HIDDEN, 3)
    )
    adam = torch.optim.Adam(network.parameters(), lr=5e-3)
    for _ in range(steps):
        error = random.uniform(-WIDEST, WIDEST, (BATCH, 3))
        x, y = (torch.tensor(one, dtype=torch.float32) for one in (error, imitated(error)))
        loss = torch.nn.functional.mse_loss(network(x), y)
        adam.zero_grad()
        loss.backward()
        adam.step()
    print(f"Root of the mean squared error of the imitation: {loss.item() ** 0.5:.3f} m/s")
    return network.eval()


def exported(network: Any) -> bytes:
    """Return a network of PyTorch in ONNX's format; its input is called `error`."""
    import torch  # noqa: PLC0415 - to pack a network needs no PyTorch

    file = io.BytesIO()
    made = torch.onnx.export(
        network, (torch.zeros(1, 3),), input_names=["error"], output_names=["command"], dynamo=True
    )
    made.save(file)
    return file.getvalue()


def pack(network: bytes, out: Path) -> None:
    """Write the archive that is submitted."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.py", CONTROLLER)
        archive.writestr("policy.onnx", network)


def main() -> None:
    """Train, export and pack."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("onnx_controller.zip"))
    parser.add_argument("--steps", type=int, default=STEPS)
    chosen = parser.parse_args()
    try:
        network = trained(chosen.steps)
    except ModuleNotFoundError as missing:
        sys.exit(f"{missing}. This example needs PyTorch: pip install torch onnx onnxscript")
    pack(exported(network), chosen.out)
    print(f"Wrote {chosen.out}. Try it: seamark run currents-v1 --controller {chosen.out}")


if __name__ == "__main__":
    main()
