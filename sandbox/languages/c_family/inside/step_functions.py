"""The step functions of a source: whether it is ours to call, or the code of a model."""

import re

OF_SEAMARK = re.compile(r"\bseamark_(step|tracker_start|tracker_update|detect)\b")
ANY_STEP = re.compile(r"\bvoid\s+(\w+)_step\s*\(")


def looks_generated(text: str) -> bool:
    """Return whether this may be the code of a model: it has a step function, and none of ours."""
    return OF_SEAMARK.search(text) is None and ANY_STEP.search(text) is not None
