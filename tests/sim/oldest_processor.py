"""Variables by which Numba compiles for the oldest x86-64, and glibc fuses no operations.

What is compiled for it is kept, as that for this processor is, but apart from that.
"""

from pathlib import Path

_KEPT = Path(__file__).parents[2] / ".pytest_cache" / "d" / "compiled-for-the-oldest-processor"
OLDEST_PROCESSOR = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
    "NUMBA_CACHE_DIR": str(_KEPT),
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA",
}
