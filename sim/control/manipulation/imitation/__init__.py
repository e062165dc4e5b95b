"""A policy that learned from demonstrations: how it was trained, features, network, weights.

`examples/imitation/train.py --keep` writes policy.json and weights.npz. This module is light: it
tells what the leaderboard says of the entry.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

POLICY: Mapping[str, Any] = json.loads(Path(__file__).with_name("policy.json").read_text("utf-8"))


def notes() -> str:
    """Return how the policy was trained: when, on what, with which seeds, at what cost."""
    shown, training = POLICY["demonstrations"], POLICY["training"]
    first, last = shown["seeds"]
    return (
        f"A network that was trained offline on {POLICY['trained']}, by behaviour cloning. "
        f"Demonstrations: {shown['episodes']} of the {shown['expert']} entry on the seeds {first} "
        f"to {last}, {shown['successful']} of them successful, "
        f"{shown['cpu_s']} s of processor time. "
        f"Training: seed {training['seed']}, {training['steps']} steps, "
        f"{training['cpu_s']} s of processor time."
    )
