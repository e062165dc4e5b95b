"""What the tests compiled, although all was to be compiled before them."""

import os
import re
import time
from collections.abc import Iterator

from seamark.sim.numerics.numba_internals import numba_folder

_CODE = re.compile(r"(?P<name>.+)-\d+\.py\d+\.\d+\.nbc")  # of a function for some types


class LateCompilation:
    """The functions of the simulator that are compiled from now on, by any process."""

    def __init__(self) -> None:
        self._folder = numba_folder(os.environ)
        self._since = time.time()

    def functions(self) -> list[str]:
        """Return them by module and name, one for each kind of arguments."""
        return sorted(self._compiled())

    def _compiled(self) -> Iterator[str]:
        for path in self._folder.glob("numba-*/*.nbc"):
            code = _CODE.fullmatch(path.name)
            if code and path.stat().st_mtime >= self._since:
                yield code["name"]
