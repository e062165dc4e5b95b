"""Arrays without reference counts, for compiled loops over several threads.

Every slice of an array counts a reference in the memory that all slices share, and two threads that
count in one place wait for each other. A borrowed array has no counter; whoever owns the memory
must outlive it.
"""

from typing import Any

from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def borrowed(typing_context: Any, array: Any) -> Any:
    """Return the same array without its reference count; only for use in compiled code."""

    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        owner = context.make_array(array)(context, builder, arguments[0])
        copy = context.make_array(array)(context, builder, value=owner._getvalue())
        copy.meminfo = cgutils.get_null_value(copy.meminfo.type)
        copy.parent = cgutils.get_null_value(copy.parent.type)
        return copy._getvalue()

    return array(array), lower
