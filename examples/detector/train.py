"""Train a network to recognise the objects of patterns-v1 with PyTorch, and pack it as a detector.

    pip install "seamark[box]" torch onnx
    seamark dataset patterns-v1 --images 14400 --seed 1 --format csv --out shown.zip
    python examples/detector/train.py shown.zip --out detector.zip
    seamark run patterns-v1 --controller detector.zip

A small convolutional network tells for each cell of 8 x 8 pixels which objects have their centre
there, and the upright box and the corners of such an object (CenterNet: Zhou, Wang and Krähenbühl
2019; scores with soft targets: Li et al. 2020). It starts from random weights and nothing is
fetched. The CPU version of PyTorch is enough.

The same images and the same seed give the same weights only where PyTorch adds in the same order,
which depends on the processor.
"""

import argparse
import hashlib
import json
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from packing import Layers, exported, pack
from shown import CLASSES, Shown

try:
    import torch
except ImportError as missing:
    sys.exit(f"{missing}. This example needs PyTorch (for the CPU): pip install torch onnx")
from torch import nn
from torch.nn import functional

from seamark.sim.detectors.network.layers import ADDED, KEPT, LAST, LAYERS
from seamark.sim.detectors.network.reading import answers, views

BATCH, RATE, DECAY = 16, 2e-3, 1e-4
SCORE_LOSS, CORNER_LOSS = 4.0, 0.5


class Network(nn.Module):
    """The layers; a norm follows each, which becomes a part of it when the training is over."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.ModuleDict()
        for name, (inputs, outputs, stride) in LAYERS.items():
            layer = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=name == LAST)
            normed = nn.Sequential(layer, nn.BatchNorm2d(outputs), nn.ReLU())
            self.layers[name] = layer if name == LAST else normed
        last = self.layers[LAST]
        nn.init.normal_(last.weight, 0.0, 0.01)
        nn.init.zeros_(last.bias)
        nn.init.constant_(last.bias[:CLASSES], -3.0)  # objects are rare

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return the output for views (n, VIEWS, 120, 160)."""
        kept = x
        for name, layer in self.layers.items():
            x = layer(x)
            if name == KEPT:
                kept = x
            if name == ADDED:
                x = kept + functional.interpolate(x, scale_factor=2.0, mode="nearest")
        return x

    def folded(self) -> Layers:
        """Return weights (outputs, inputs, 3, 3) and biases of each layer, in float16's numbers."""
        result = {}
        for name, layer in self.layers.items():
            convolution, norm = (layer, None) if isinstance(layer, nn.Conv2d) else layer[:2]
            weights, biases = convolution.weight, convolution.bias
            if norm is not None:
                scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
                weights = weights * scale[:, None, None, None]
                biases = norm.bias - norm.running_mean * scale
            result[name] = tuple(
                one.detach().numpy().astype(np.float16).astype(np.float32)
                for one in (weights, biases)
            )
        return result


def loss_of(output: torch.Tensor, wanted: list[torch.Tensor]) -> torch.Tensor:
    """Return the loss of a batch."""
    scores, weights, shape, near = wanted
    logits, told = output[:, :CLASSES], output[:, CLASSES:]
    off = (scores - torch.sigmoid(logits)).detach()
    of_scores = functional.binary_cross_entropy_with_logits(logits, scores, reduction="none")
    of_boxes = functional.smooth_l1_loss(told[:, :4], shape[:, :4], reduction="none", beta=0.1)
    of_corners = (torch.sigmoid(told[:, 4:]) - shape[:, 4:]).abs()
    of_shapes = of_boxes.sum(dim=1) + CORNER_LOSS * of_corners.sum(dim=1)
    total = SCORE_LOSS * (of_scores * off * off * weights).sum() + (of_shapes * near).sum()
    return total / near.sum().clamp(min=1.0)


def trained(shown: Shown, passes: int, seed: int, *, bfloat16: bool) -> Network:
    """Return a network that has seen all images a number of times."""
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    network = Network().to(memory_format=torch.channels_last)
    adam = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    batches = len(shown.files) // BATCH
    rates = torch.optim.lr_scheduler.OneCycleLR(
        adam, RATE, total_steps=passes * batches, pct_start=0.1
    )
    for one in range(1, passes + 1):
        order, total = random.permutation(len(shown.files)), 0.0
        for numbers in order[: batches * BATCH].reshape(batches, BATCH):
            samples = [shown.sample(k, turned=random.random() < 0.5) for k in numbers]
            seen, *wanted = (
                torch.from_numpy(np.array(each)) for each in zip(*samples, strict=True)
            )
            with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
                output = network(seen.to(memory_format=torch.channels_last))
            loss = loss_of(output.float(), wanted)
            adam.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(network.parameters(), 5.0)
            adam.step()
            rates.step()
            total += loss.item()
        cpu_s = time.process_time()
        print(f"  pass {one}: loss {total / batches:.3f}, {cpu_s:.0f} s of processor", flush=True)
    return network.eval()


class Learned:
    """The network as a detector of the simulator, to evaluate it."""

    def __init__(self, model: bytes) -> None:
        import onnxruntime  # noqa: PLC0415

        self.session = onnxruntime.InferenceSession(model)
        self.colour = False

    def detect(self, image: np.ndarray) -> list[Any]:
        """Return what is in an image."""
        from seamark.sim.detectors import Detection  # noqa: PLC0415

        [output] = self.session.run(None, {"views": views(image)[None]})
        return [Detection(*each) for each in answers(output[0])]


def evaluate(model: bytes, seeds: list[int]) -> None:
    """Print the average precision of each level, mean over practice seeds, and the score."""
    from seamark.sim.engine.trial import run_trial  # noqa: PLC0415
    from seamark.sim.registry import benchmark  # noqa: PLC0415

    patterns = benchmark("patterns-v1")
    config, experiment = patterns.read({}), patterns.load()
    precisions, scores = [], []
    for seed in seeds:
        rows: list[np.ndarray] = []
        run_trial(
            patterns.name,
            config,
            Learned(model),
            seed=seed,
            trial=0,
            on_rows=lambda some, rows=rows: rows.append(some.copy()),
        )
        of_levels = np.split(np.concatenate(rows), len(config.optical_depths))
        levels = [experiment.metrics(config, level, each) for level, each in enumerate(of_levels)]
        precisions.append([level["ap_percent"] for level in levels])
        scores.append(experiment.trial_score(config, levels).score)
    for depth, precision in zip(config.optical_depths, np.mean(precisions, axis=0), strict=True):
        print(f"  optical depth {depth:g}: average precision {precision:.1f} %")
    print(f"  score {np.mean(scores):.2f}, seeds {seeds[0]} to {seeds[-1]}")


def main() -> None:
    """Train, pack and evaluate."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("shown", type=Path, help="Images as `seamark dataset --format csv` writes.")
    parser.add_argument("--passes", type=int, default=3, help="Over all images.")
    parser.add_argument("--seed", type=int, default=1, help="Of the training.")
    parser.add_argument("--threads", type=int, default=2, help="Of PyTorch.")
    parser.add_argument(
        "--bfloat16", action="store_true", help="Twice as fast where the processor has it."
    )
    parser.add_argument("--seeds", type=int, default=8, help="How many, from 700, to evaluate it.")
    parser.add_argument("--out", type=Path, default=Path("detector.zip"))
    parser.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="Write network.json and weights.npz there, too."
    )
    chosen = parser.parse_args()
    torch.set_num_threads(chosen.threads)
    shown, began = Shown(chosen.shown), time.process_time()
    network = trained(shown, chosen.passes, chosen.seed, bfloat16=chosen.bfloat16)
    cost_s, layers = time.process_time() - began, network.folded()
    model = exported(layers)
    pack(model, chosen.out)
    print(f"Wrote {chosen.out}, after {cost_s:.0f} s of processor time for the training.")
    if chosen.keep:
        keep(chosen.keep, layers, shown.manifest, chosen, cost_s)
    evaluate(model, list(range(700, 700 + chosen.seeds)))


def keep(
    folder: Path,
    layers: Layers,
    manifest: dict[str, Any],
    chosen: argparse.Namespace,
    cost_s: float,
) -> None:
    """Write the weights and how they were trained, for the entry `network`."""
    arrays = {
        f"{name}.{part}": array.astype(np.float16)
        for name, both in layers.items()
        for part, array in zip(("weights", "biases"), both, strict=True)
    }
    weights = folder / "weights.npz"
    np.savez(weights, **arrays)
    how = {
        "trained": datetime.now(UTC).date().isoformat(),
        "images": {name: manifest[name] for name in ("benchmark", "images", "seed")},
        "training": {
            **{name: getattr(chosen, name) for name in ("seed", "passes", "bfloat16")},
            "cpu_s": round(cost_s),
        },
        "weights_sha256": hashlib.sha256(weights.read_bytes()).hexdigest(),
    }
    (folder / "network.json").write_text(json.dumps(how, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
