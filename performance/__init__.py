"""Speed and memory beside peers, validation, and what the scores mean: see `commands`."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
FIGURES = DOCS / "figures"
