"""The layout with which Foxglove (and Lichtblick) shows the topics of a run."""

from __future__ import annotations

from pathlib import Path

FILE = "foxglove-layout.json"
TEXT = Path(__file__).with_name(FILE).read_bytes()
