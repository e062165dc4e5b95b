"""What a program prints here and elsewhere, such as on the oldest x86-64.

There Numba compiles for it, and glibc fuses no operations. What is compiled for it is kept, as that
for this processor is, but apart from that.
"""

import io
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from unittest.mock import patch

_KEPT = Path(__file__).parents[2] / ".pytest_cache" / "d" / "compiled-for-the-oldest-processor"
OLDEST_PROCESSOR = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "NUMBA_CACHE_DIR": str(_KEPT),
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA",
}
# All that NumPy does in another way where a processor has it.
NUMPY_OLDEST = {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"}


def printed_here(program: str, *arguments: str) -> str:
    """Return what a Python program prints in this process, which has loaded what it needs.

    If another process prints the same, neither hashes nor what ran before have a part in it.
    """
    said = io.StringIO()
    with redirect_stdout(said), patch.object(sys, "argv", ["-c", *arguments]):
        exec(program, {"__name__": "__main__"})  # noqa: S102  our own
    return said.getvalue()


def printed(
    program: str, variables: Mapping[str, str], *options: str, arguments: Sequence[str] = ()
) -> str:
    """Return what a Python program prints in a process of its own, with these variables more."""
    done = subprocess.run(
        [sys.executable, *options, "-c", program, *arguments],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "1", **variables},
    )
    return done.stdout
