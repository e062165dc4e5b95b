"""What the service says of itself: log, metrics, outages.

Importing this package loads structlog: without Rich, which it would load to colour tracebacks and
which took a twentieth of the start of each process. The log has plain ones.
"""

import importlib
import sys
from typing import Any


def _load_structlog_alone(*absent: str) -> None:
    """Load structlog as if the packages were not installed for which it looks."""
    modules: dict[str, Any] = sys.modules
    hidden = [name for name in absent if name not in modules]
    modules.update(dict.fromkeys(hidden))
    try:
        importlib.import_module("structlog")
    finally:
        for name in hidden:
            del modules[name]


_load_structlog_alone("rich", "twisted")
