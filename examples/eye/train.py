"""Train an eye for currents-v2 with PyTorch, and pack it with a trained hand as ONNX.

    pip install "seamark[gym,box]" "stable-baselines3>=2.9" onnx
    python examples/ppo/train.py --out hand.zip
    python examples/eye/train.py hand.zip --out eye.zip
    seamark run currents-v2 --controller eye.zip --set images=vehicle --trials 8
    seamark submit currents-v2 --controller eye.zip --set images=vehicle --ranked --wait

The first round has images of vehicles that wander about, the second of vehicles that the entry
steers with the eye of the first one (DAgger: Ross, Gordon and Bagnell 2011). The same seed gives
the same weights where PyTorch adds in the same order, which depends on the processor. In the end
the archive steers from a sandbox, and has to act as the reference entry `pixels` with the same
weights, which steers in the second round. `--keep` writes what that entry is made of.
"""

import argparse
import io
import json
import sys
import time
import zipfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

try:
    import onnx
    import torch
except ImportError as missing:
    sys.exit(
        "This example needs PyTorch, of which the CPU version is enough, and ONNX: "
        f"pip install torch onnx. Python says: {missing}"
    )
import numpy as np
from looking import KINDS, Pupil, Shown, Wanderer, look
from packing import beside, pack
from torch import nn

from seamark.sim.control.position.pixels.eye import CELL_PX, COLUMNS, LAYERS, ROWS

VEHICLES, SECONDS = 64, 60.0  # of each kind in a round, and how long it looks
SEEDS, OTHER_SEEDS = 100_000, 500_000  # of the images to learn from, and of those to judge by
SEEDS_APART = 1000  # of rounds and kinds
OTHERS = 16  # vehicles of each kind to judge by
PASSES, BATCH, RATE = 3, 32, 2e-3
OFFSETS_WEIGH = 4.0
FAR = 1.1  # cells beside that of the target, which learn where it is too
SHOWN_EVERY = 500  # steps
TOLERANCE = 1e-5  # [m/s, rad/s]: float32, added in another order


def new_network() -> nn.Sequential:
    """Return the eye as it is trained."""
    parts: list[nn.Module] = []
    for inputs, outputs, stride in LAYERS:
        parts += [nn.Conv2d(inputs, outputs, 3, stride=stride, padding=1), nn.ReLU()]
    return nn.Sequential(*parts[:-1])


def weights_of(network: nn.Sequential) -> dict[str, np.ndarray]:
    """Return the weights as the entry keeps them."""
    found = {}
    for number, layer in enumerate(network[::2]):
        found[f"eye_weights{number}"] = layer.weight.detach().numpy().copy()
        found[f"eye_biases{number}"] = layer.bias.detach().numpy().copy()
    return found


def loss_of(output: torch.Tensor, labels: torch.Tensor) -> torch.Tensor:
    """Return the loss: which cell has the target, or none; and where it is from cells near it."""
    seen = labels[:, 0] > 0
    across, along = labels[:, 1] / CELL_PX + COLUMNS / 2, labels[:, 2] / CELL_PX + ROWS / 2
    column = across.floor().long().clamp(0, COLUMNS - 1)
    row = along.floor().long().clamp(0, ROWS - 1)
    cell = torch.where(seen, row * COLUMNS + column, ROWS * COLUMNS)
    scores = torch.cat([output[:, 0].flatten(1), torch.zeros(len(output), 1)], dim=1)
    right = across[:, None, None] - 0.5 - torch.arange(COLUMNS)[None, None, :]
    down = along[:, None, None] - 0.5 - torch.arange(ROWS)[None, :, None]
    near = (right.abs() < FAR) & (down.abs() < FAR) & seen[:, None, None]
    goal = torch.stack(torch.broadcast_tensors(right, down), dim=1)
    off = nn.functional.smooth_l1_loss(output[:, 1:], goal, beta=0.05, reduction="none").sum(1)
    offset = (off * near).sum() / near.sum().clamp(min=1)
    return nn.functional.cross_entropy(scores, cell) + OFFSETS_WEIGH * offset


def train(network: nn.Sequential, shown: Shown, seed: int) -> None:
    """Train with all images that were shown; every second batch is upside down."""
    images = torch.from_numpy(np.array(shown.images))
    labels = torch.from_numpy(np.array(shown.labels))
    random = torch.Generator().manual_seed(seed)
    batches = len(images) // BATCH
    optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=1e-4)
    rates = torch.optim.lr_scheduler.OneCycleLR(
        optimiser, RATE, total_steps=PASSES * batches + 1, pct_start=0.1
    )
    for step in range(PASSES * batches):
        if step % batches == 0:
            order = torch.randperm(len(images), generator=random)
        chosen = order[step % batches * BATCH :][:BATCH]
        image, label = images[chosen].float()[:, None], labels[chosen]
        if step % 2:
            image, label = image.flip(2, 3), label * torch.tensor([1.0, -1.0, -1.0])
        loss = loss_of(network(image), label)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        rates.step()
        if step % SHOWN_EVERY == 0:
            print(f"  step {step} of {PASSES * batches}, loss {loss.item():.3f}", flush=True)


def judged(network: nn.Sequential, others: Shown) -> dict[str, float]:
    """Return how good the eye is with images of vehicles from which it has not learned."""
    with torch.no_grad():
        batches = torch.from_numpy(np.array(others.images)).float()[:, None].split(256)
        output = torch.cat([network(batch) for batch in batches]).flatten(2).numpy()
    labels = np.array(others.labels)
    seen, best = labels[:, 0] > 0, output[:, 0].argmax(axis=1)
    score, right, down = output[np.arange(len(best)), :, best].T
    x = CELL_PX * (best % COLUMNS + 0.5 + right - COLUMNS / 2)
    y = CELL_PX * (best // COLUMNS + 0.5 + down - ROWS / 2)
    error = np.hypot(x - labels[:, 1], y - labels[:, 2])[seen & (score > 0)]
    return {
        "images": len(best),
        "seen": round(float(seen.mean()), 4),
        "missed": round(float((seen & (score <= 0)).mean()), 4),
        "invented": round(float((~seen & (score > 0)).mean()), 4),
        "median_px": round(float(np.median(error)), 2),
        "p95_px": round(float(np.percentile(error, 95)), 2),
    }


def hand_of(archive: Path) -> dict[str, np.ndarray]:
    """Return the weights of a hand that `examples/ppo` has packed."""
    with zipfile.ZipFile(archive) as packed:
        model = onnx.load(io.BytesIO(packed.read("policy.onnx")))
    stored = model.graph.initializer
    return {f"hand_{array.name}": onnx.numpy_helper.to_array(array) for array in stored}


def difference(archive: Path, weights: dict[str, np.ndarray]) -> float:
    """Return by how much the archive in its box differs from the entry [m/s, rad/s]."""
    level = {"levels": [0.3], "tracker": "truth"}
    commands = (beside(archive, weights, kind, **level) for kind in KINDS)
    return max(float(np.abs(boxed - trained).max()) for boxed, trained in commands)


def keep(folder: Path, weights: dict[str, np.ndarray], notes: dict[str, Any]) -> None:
    """Write what the reference entry is made of."""
    np.savez(folder / "weights.npz", **weights)
    text = json.dumps(notes, indent=1) + "\n"
    (folder / "eye.json").write_text(text, encoding="utf-8")


def learned(
    network: nn.Sequential, hand: dict[str, np.ndarray], chosen: argparse.Namespace
) -> dict[str, Any]:
    """Train the network in two rounds; return what is known of them."""
    shown, found = Shown(), {}
    spent = {"looking": 0.0, "training": 0.0}
    for turn, name in enumerate(("wandering", "as the entry")):
        begin, others = time.process_time(), Shown()
        for number, kind in enumerate(KINDS):
            count, seed = chosen.vehicles, SEEDS_APART * (len(KINDS) * turn + number)
            for into, first, many in ((shown, SEEDS, count), (others, OTHER_SEEDS, OTHERS)):
                wanderer = Wanderer(many, np.random.default_rng(seed + chosen.seed))
                pupil = Pupil(many, kind, weights_of(network) | hand) if turn else None
                driver = pupil or wanderer
                look(into, kind, driver, seed=first + seed, count=many, seconds=chosen.seconds)
        looked = time.process_time()
        print(f"{name}: {len(shown.images)} images, {looked - begin:.0f} s", flush=True)
        train(network, shown, chosen.seed)
        spent["looking"] += looked - begin
        spent["training"] += time.process_time() - looked
        found[name] = judged(network, others)
        print(f"{name}: {found[name]}, {time.process_time() - looked:.0f} s", flush=True)
    return {
        "trained": f"{datetime.now(UTC):%Y-%m-%d}",
        "images": len(shown.images),
        "seeds": [SEEDS, SEEDS + SEEDS_APART * 3 + chosen.vehicles - 1],
        "seed": chosen.seed,
        "cpu_s": {name: round(seconds) for name, seconds in spent.items()},
        "judged": found,
    }


def main() -> None:
    """Look, train, look as the entry, train, judge, pack and check."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("hand", type=Path, help="Archive of examples/ppo/train.py.")
    parser.add_argument("--seed", type=int, default=1, help="Of the training.")
    parser.add_argument("--vehicles", type=int, default=VEHICLES, help="Of each kind in a round.")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="That each of them looks.")
    parser.add_argument("--out", type=Path, default=Path("eye.zip"))
    parser.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="Write eye.json and weights.npz there, too."
    )
    chosen = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(chosen.seed)
    network, hand = new_network(), hand_of(chosen.hand)
    notes = learned(network, hand, chosen)
    weights = weights_of(network) | hand
    pack(weights, chosen.hand, chosen.out)
    if chosen.keep:
        keep(chosen.keep, weights, notes)
    if (off := difference(chosen.out, weights)) > TOLERANCE:
        sys.exit(f"{chosen.out} acts otherwise in its box than in training, by {off:g} m/s.")
    print(f"Wrote {chosen.out} after {sum(notes['cpu_s'].values())} s of processor time.")
    print(f"In its box it acts as in training, to {off:.1g} m/s.")
    print("Evaluate and submit it:")
    options = f"currents-v2 --controller {chosen.out} --set images=vehicle"
    print(f"  seamark run {options} --trials 8")
    print(f"  seamark submit {options} --ranked --wait")


if __name__ == "__main__":
    main()
