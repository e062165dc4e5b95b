"""Values of many owners in one table, for compiled loops: a row of words for each of them.

Numba has no list of tuples of arrays without reference counts (see `borrowed.py`), and arrays of
different lengths have no common table. So a tuple is lent: its numbers, and the addresses and
shapes of its arrays, are words of 64 bits. Whoever owns the arrays must outlive the row.
"""

import struct
from itertools import count
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Integers

_Lent = TypeVar("_Lent")


def lend(value: Any) -> NDArray[np.int64]:
    """Return the words (k,) of a number, an array, or nested tuples of them.

    Raises
    ------
    TypeError
        An array is not C-contiguous, or something else is in a tuple.
    """
    return np.array(_words(value), np.int64)


def _words(value: Any) -> list[int]:
    if isinstance(value, tuple):
        return [word for part in value for word in _words(part)]
    if isinstance(value, np.ndarray) and value.flags.c_contiguous:
        return [value.ctypes.data, *value.shape]
    if isinstance(value, bool | int | np.integer | np.bool_):
        return [int(value)]
    if isinstance(value, float | np.float64):
        return [struct.unpack("q", struct.pack("d", value))[0]]
    raise TypeError(f"a {type(value).__name__} cannot be lent")


if TYPE_CHECKING:

    def recalled(words: Integers, like: _Lent) -> _Lent:
        """Return the value whose words (k,) these are, without counters; only in compiled code.

        `like` has the types of the value: another one that was lent the same way.
        """


@intrinsic
def _recalled(typing_context: Any, words: Any, like: Any) -> Any:
    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        row = context.make_array(words)(context, builder, arguments[0])
        place = count()

        def take() -> Any:
            at = context.get_constant(types.intp, next(place))
            return builder.load(builder.gep(row.data, [at]))

        return _rebuilt(context, builder, like, take)

    return like(words, like), lower


if not TYPE_CHECKING:
    recalled = _recalled


def _rebuilt(context: Any, builder: Any, kind: Any, take: Any) -> Any:
    if isinstance(kind, types.BaseTuple):
        known: Any = kind
        parts = [_rebuilt(context, builder, part, take) for part in known.types]
        return context.make_tuple(builder, kind, parts)
    if isinstance(kind, types.Array):
        return _array_at(context, builder, kind, take)
    word = take()
    if isinstance(kind, types.Boolean):
        return builder.icmp_signed("!=", word, word.type(0))
    if kind == types.float64:
        return builder.bitcast(word, context.get_value_type(kind))
    if kind == types.int64:
        return word
    raise TypeError(f"a {kind} cannot be recalled")


def _array_at(context: Any, builder: Any, kind: Any, take: Any) -> Any:
    if kind.layout != "C":
        raise TypeError(f"an array of layout {kind.layout} cannot be recalled")
    array = context.make_array(kind)(context, builder)
    data = builder.inttoptr(take(), array.data.type)
    shape = [take() for _ in range(kind.ndim)]
    word = shape[0].type
    size = word(context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides = [size]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    populate: Any = populate_array
    pack: Any = cgutils.pack_array
    shape, strides = pack(builder, shape, word), pack(builder, strides, word)
    populate(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
    return array._getvalue()
