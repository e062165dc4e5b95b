"""A policy that looks: a learned eye, dead reckoning and a learned hand, and how both learned.

`examples/eye/train.py --keep` writes eye.json and weights.npz, which are our own work and have the
licence of the simulator (Apache-2.0). This module is light: it tells what the leaderboard says of
the entry.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

TRAINED: Mapping[str, Any] = json.loads(Path(__file__).with_name("eye.json").read_text("utf-8"))


def notes() -> str:
    """Return how the entry was trained: when, on what, with which seeds, at what cost."""
    first, last = TRAINED["seeds"]
    cost = sum(TRAINED["cpu_s"].values())
    return (
        f"It uses nothing of the tracker. A convolutional network finds the target in each image, "
        f"the DVL tells where it is in between, and a policy that PPO trained with the true "
        f"position steers. The eye was trained on {TRAINED['trained']} with {TRAINED['images']} "
        f"images of vehicles with the seeds {first} to {last}, which no ranked trial has: {cost} s "
        f"of processor time."
    )
