"""The oldest x86-64, and what a program prints on this processor.

There Numba compiles for it, and glibc fuses no operations. What is compiled for it is kept, as that
for this processor is, but apart from that.
"""

import io
import sys
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
# All that NumPy and OpenCV do in another way where a processor has it.
OLDEST_LIBRARIES = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    "OPENCV_CPU_DISABLE": "AVX2,FMA3,AVX,FP16,AVX512-SKX,SSE4.2,SSE4.1,SSSE3",
}


def printed_here(program: str, *arguments: str) -> str:
    """Return what a Python program prints in this process, which has loaded what it needs.

    If another process prints the same, neither hashes nor what ran before have a part in it.
    """
    said = io.StringIO()
    with redirect_stdout(said), patch.object(sys, "argv", ["-c", *arguments]):
        exec(program, {"__name__": "__main__"})  # noqa: S102  our own
    return said.getvalue()
