"""Small arrays in a compiled function's own memory, which cost neither allocation nor counting.

An array from `np.empty` is allocated, counted at each slice and call, and freed: for a 3x3 matrix
this takes longer than to multiply two. One from here is gone when the function returns, so it may
be handed to functions that are called, but never be returned or kept.
"""

import math
from typing import TYPE_CHECKING, Any

from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

_ALIGNMENT = 64  # [bytes] a cache line, and the widest vector


if TYPE_CHECKING:

    def on_stack(dtype: Any, *lengths: int) -> Any:
        """Return an array of a type like np.float64 with unset elements; only in compiled code.

        The lengths are numbers in the source, or constants of the module.
        """


@intrinsic(prefer_literal=True)
def _on_stack(typing_context: Any, dtype: Any, *shape: Any) -> Any:
    if not all(isinstance(length, types.IntegerLiteral) for length in shape):
        return None
    lengths = [length.literal_value for length in shape]
    array_type = types.Array(dtype.dtype, len(lengths), "C")
    starred: Any = types.StarArgTuple

    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        element, word = context.get_data_type(dtype.dtype), context.get_value_type(types.intp)
        with builder.goto_entry_block():
            memory = builder.alloca(element, word(math.prod(lengths)))
        memory.align = _ALIGNMENT
        size = context.get_abi_sizeof(element)
        steps = [size * math.prod(lengths[k + 1 :]) for k in range(len(lengths))]
        array = context.make_array(array_type)(context, builder)
        populate: Any = populate_array
        pack: Any = cgutils.pack_array
        shape = pack(builder, [word(length) for length in lengths], word)
        strides = pack(builder, [word(step) for step in steps], word)
        populate(
            array, data=memory, shape=shape, strides=strides, itemsize=word(size), meminfo=None
        )
        return array._getvalue()

    return array_type(dtype, starred.from_types(shape)), lower


if not TYPE_CHECKING:
    on_stack = _on_stack
