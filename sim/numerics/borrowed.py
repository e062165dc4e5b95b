"""Arrays without reference counts, for compiled loops over several threads.

Every slice of an array, and every tuple with one, counts a reference in memory that all share. The
counting takes time, and two threads that count in the same memory wait for each other.
A borrowed array has no counter; whoever owns the memory must outlive it.
"""

from typing import Any

from numba.core import cgutils, types
from numba.extending import intrinsic


@intrinsic
def borrowed(typing_context: Any, value: Any) -> Any:
    """Return an array, or nested tuples of them, without its counter; only in compiled code."""

    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _borrowed(context, builder, value, arguments[0])

    return value(value), lower


def _borrowed(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value=value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        for at, part in enumerate(kind):
            old = builder.extract_value(value, at)
            value = builder.insert_value(value, _borrowed(context, builder, part, old), at)
    return value
