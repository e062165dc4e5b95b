"""Train the eye."""

import argparse
import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

import seamark.gym
from seamark.sim.control.position.pixels.eye import (
    CELL_PX,
    COLUMNS,
    HEIGHT,
    HEIGHT_PX,
    LAYERS,
    ROWS,
    WIDTH,
    WIDTH_PX,
    normalise,
)

LEVEL_S = 30.0
ERROR, PX, VISIBLE, VELOCITY, YAW = slice(2, 4), slice(5, 7), 7, slice(9, 11), 17


class Shown:
    """Images with where the target is in them."""

    def __init__(self) -> None:
        self.images: list[NDArray[np.float16]] = []
        self.labels: list[NDArray[np.float32]] = []  # visible, right, down [px]

    def add(self, image: NDArray[np.uint8], state: NDArray[np.float64]) -> None:
        framed = np.zeros(((HEIGHT + 2) * (WIDTH + 2), 1), np.float32)
        normalise(image, framed)
        self.images.append(framed.reshape(HEIGHT + 2, WIDTH + 2)[1:-1, 1:-1].astype(np.float16))
        self.labels.append(np.array([state[VISIBLE], *state[PX]], np.float32))


class Wanderer:
    """Goes near a place beside the target and turns: a law that sees the true error."""

    def __init__(self, count: int, random: np.random.Generator) -> None:
        self.count, self.random = count, random
        self.goal, self.heading, self.integral = np.zeros((count, 2)), np.zeros(count), np.zeros((count, 2))

    def begin(self, over: NDArray[np.bool_]) -> None:
        n = int(over.sum())
        self.goal[over] = self.random.uniform(-1.1, 1.1, (n, 2))
        self.heading[over] = self.random.uniform(-np.pi, np.pi, n)
        self.integral[over] = 0.0

    def commands(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        off = states[:, ERROR] - self.goal * states[:, VISIBLE, None]
        self.integral = np.clip(self.integral + 0.05 * 0.3 * off, -0.6, 0.6)
        turn = np.angle(np.exp(1j * (self.heading - states[:, YAW])))
        return np.column_stack([0.8 * off + self.integral, np.zeros(self.count), 0.5 * turn]).clip(-0.6, 0.6)


def collect(shown: Shown, *, seed: int, count: int, seconds: float, every: int, driver: Any) -> None:
    times = {"level_duration_s": LEVEL_S, "settle_s": 0.25 * LEVEL_S}
    envs = gymnasium.make_vec(
        "seamark/StationKeeping-v2",
        num_envs=count,
        observation="image+state",
        image_size=(WIDTH_PX, HEIGHT_PX),
        settings={"tracker": "truth"} | times,
    )
    seen, _ = envs.reset(seed=seed, options={})
    for i in range(count):  # both vehicles and all levels at once
        mask = np.zeros(count, bool)
        mask[i] = True
        seen, _ = envs.reset(options={"reset_mask": mask, "trial": i % 2, "level": i // 2 % 8})
    driver.begin(np.ones(count, bool))
    before = seen["image"][:, ::97, ::89].copy()
    since = np.arange(count) % every
    for step in range(round(seconds / 0.05)):
        seen, _, terminated, truncated, _ = envs.step(driver.commands(seen["state"]))
        driver.begin(terminated | truncated)
        now = seen["image"][:, ::97, ::89].copy()
        new = (now != before).any(axis=(1, 2, 3))
        before = now
        since[new] += 1
        for i in np.flatnonzero(new & (since >= every)):
            since[i] = 0
            shown.add(seen["image"][i, :, :, 0], seen["state"][i])
    envs.close()


class Net(nn.Sequential):
    def __init__(self) -> None:
        layers: list[nn.Module] = []
        for number, (inputs, outputs, stride) in enumerate(LAYERS):
            layers.append(nn.Conv2d(inputs, outputs, 3, stride=stride, padding=1))
            if number < len(LAYERS) - 1:
                layers.append(nn.ReLU())
        super().__init__(*layers)

    def arrays(self) -> dict[str, NDArray[np.float32]]:
        convs = [each for each in self if isinstance(each, nn.Conv2d)]
        out = {}
        for n, c in enumerate(convs):
            out[f"weights{n}"], out[f"biases{n}"] = c.weight.detach().numpy().copy(), c.bias.detach().numpy().copy()
        return out


def loss_of(out: torch.Tensor, labels: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    n = len(out)
    x = labels[:, 1] / CELL_PX + COLUMNS / 2
    y = labels[:, 2] / CELL_PX + ROWS / 2
    visible = labels[:, 0] > 0
    column, row = x.floor().long().clamp(0, COLUMNS - 1), y.floor().long().clamp(0, ROWS - 1)
    goal = torch.where(visible, row * COLUMNS + column, ROWS * COLUMNS)
    scores = torch.cat([out[:, 0].flatten(1), torch.zeros(n, 1)], 1)
    told = nn.functional.cross_entropy(scores, goal)
    rows, columns = torch.meshgrid(torch.arange(ROWS), torch.arange(COLUMNS), indexing="ij")
    right, down = x[:, None, None] - columns - 0.5, y[:, None, None] - rows - 0.5
    near = (right.abs() < 1.1) & (down.abs() < 1.1) & visible[:, None, None]
    off = nn.functional.smooth_l1_loss(out[:, 1], right, beta=0.05, reduction="none")
    off = off + nn.functional.smooth_l1_loss(out[:, 2], down, beta=0.05, reduction="none")
    return told, (off * near).sum() / near.sum().clamp(min=1)


def train(net: Net, shown: Shown, *, passes: int, batch: int, rate: float, seed: int) -> None:
    images, labels = torch.from_numpy(np.array(shown.images)), torch.from_numpy(np.array(shown.labels))
    generator = torch.Generator().manual_seed(seed)
    steps = passes * (len(images) // batch)
    optimiser = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps + 1, pct_start=0.1)
    step, sums = 0, np.zeros(2)
    for _ in range(passes):
        order = torch.randperm(len(images), generator=generator)
        for at in range(0, len(images) - batch + 1, batch):
            chosen = order[at : at + batch]
            seen, label = images[chosen].float()[:, None], labels[chosen].clone()
            if step % 2:  # upside down
                seen, label[:, 1:] = seen.flip(2, 3), -label[:, 1:]
            told, off = loss_of(net(seen), label)
            optimiser.zero_grad()
            (told + 4 * off).backward()
            optimiser.step()
            schedule.step()
            step += 1
            sums = 0.98 * sums + 0.02 * np.array([told.item(), off.item()])
            if step % 100 == 0:
                print(f"{time.process_time():6.0f} s  {step}/{steps}  {sums[0]:.4f} {sums[1]:.4f}", flush=True)


def judge(net: Net, shown: Shown) -> str:
    labels = np.array(shown.labels)
    with torch.no_grad():
        out = torch.cat([net(torch.from_numpy(np.array(shown.images[a : a + 256])).float()[:, None]) for a in range(0, len(labels), 256)])
    flat = out.flatten(2).numpy()
    best = flat[:, 0].argmax(1)
    k = np.arange(len(best))
    said = flat[k, 0, best] > 0
    px = np.stack([CELL_PX * (best % COLUMNS + 0.5 + flat[k, 1, best] - COLUMNS / 2), CELL_PX * (best // COLUMNS + 0.5 + flat[k, 2, best] - ROWS / 2)], 1)
    vis = labels[:, 0] > 0
    err = np.hypot(*(px - labels[:, 1:]).T)[vis & said]
    return f"n {len(vis)} visible {vis.mean():.3f} missed {(vis & ~said).mean():.4f} invented {(~vis & said).mean():.4f} px median {np.median(err):.2f} p95 {np.percentile(err, 95):.2f} p99.9 {np.percentile(err, 99.9):.1f}"


if __name__ == "__main__":
    torch.set_num_threads(1)
    torch.manual_seed(1)
    random = np.random.default_rng(1)
    shown, other = Shown(), Shown()
    c = time.process_time()
    import sys
    secs = float(sys.argv[1])
    collect(other, seed=500_000, count=32, seconds=30, every=5, driver=Wanderer(32, random))
    print("other", len(other.labels), time.process_time() - c, flush=True)
    c = time.process_time()
    collect(shown, seed=100_000, count=128, seconds=secs, every=5, driver=Wanderer(128, random))
    print("shown", len(shown.labels), time.process_time() - c, flush=True)
    np.savez("/tmp/eye_shown.npz", i=np.array(shown.images), l=np.array(shown.labels))
    np.savez("/tmp/eye_other.npz", i=np.array(other.images), l=np.array(other.labels))
    net = Net()
    c = time.process_time()
    train(net, shown, passes=int(sys.argv[2]), batch=32, rate=2e-3, seed=1)
    print("train", time.process_time() - c)
    print(judge(net, other))
    np.savez("/tmp/eye_w0.npz", **net.arrays())
