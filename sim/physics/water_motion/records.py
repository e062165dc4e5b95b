"""Records of currents that settings can name: those shipped, and those of users."""

from functools import lru_cache
from pathlib import Path

from seamark.sim.files.library import Library
from seamark.sim.physics.water_motion.record import BYTES_MAX, Record, read_record

SUFFIX = ".csv"
FOLDER = Path(__file__).with_name("records")
SHIPPED = {path.stem: path for path in sorted(FOLDER.glob(f"*{SUFFIX}"))}
LIBRARY = Library(
    setting="current_record",
    what="record of currents",
    mark="record",
    entry="current_file",
    suffixes=(SUFFIX,),
    bytes_max=BYTES_MAX,
    read=read_record,
)


def load(name: str) -> Record:
    """Return the record of that name.

    Raises
    ------
    LookupError
        None of that name is shipped, and none was added or is lent.
    """
    return LIBRARY.get(name) or _shipped(name)


@lru_cache(maxsize=8)
def _shipped(name: str) -> Record:
    if name not in SHIPPED:
        raise LookupError(f"there is no record {name}")
    return read_record(SHIPPED[name].read_bytes())
