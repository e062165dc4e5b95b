"""Variables by which Numba compiles for the oldest x86-64, and glibc fuses no operations.

What is compiled for it is kept, as that for this processor is, but apart from that.
"""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

_KEPT = Path(__file__).parents[2] / ".pytest_cache" / "d" / "compiled-for-the-oldest-processor"
OLDEST_PROCESSOR = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "NUMBA_CACHE_DIR": str(_KEPT),
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA",
}
# All that NumPy does in another way where a processor has it.
NUMPY_OLDEST = {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"}


def printed(program: str, variables: Mapping[str, str], *options: str) -> str:
    """Return what a Python program prints in a process of its own, with these variables more."""
    done = subprocess.run(
        [sys.executable, *options, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **variables},
    )
    return done.stdout
