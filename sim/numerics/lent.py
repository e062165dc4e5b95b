"""Values of many owners in one table, for compiled loops: a row of words for each of them.

Numba has no list of tuples of arrays without reference counts (see `borrowed.py`), and arrays of
different lengths have no common table. So a tuple is lent: its numbers, and the addresses and
shapes of its arrays, are words of 64 bits. Whoever owns the arrays must outlive the row.

`Lent` is a single such value, for a function that is called again and again from Python: to unpack
a tuple of arrays takes a tenth of a microsecond for each of them, and to take its address no more
than that for all of them.
"""

import struct
from itertools import count
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numba
import numpy as np
from numba.core import cgutils, types
from numba.extending import (
    NativeValue,
    intrinsic,
    models,
    register_model,
    typeof_impl,
    unbox,
)
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


class Lent(Generic[_Lent]):
    """A value that compiled functions take from where its words are, with `taken`.

    It keeps the value, whose arrays may change in place; numbers are those of the beginning.
    """

    __slots__ = ("_value", "_words", "address", "kind")

    def __init__(self, value: _Lent) -> None:
        """Lend a number, an array, or nested tuples of them, as `lend`."""
        self._value, self._words = value, lend(value)
        self.address: int = self._words.ctypes.data
        self.kind = _kind(value)


_KINDS: dict[object, types.Type] = {}  # by what `_description` returns


def _kind(value: object) -> types.Type:
    """Return the type of a value. Numba takes a millisecond for that of all that a level has."""
    described = _description(value)
    if described not in _KINDS:
        type_of: Any = numba.typeof
        _KINDS[described] = type_of(value)
    return _KINDS[described]


def _description(value: object) -> object:
    """Return what decides the type of a value that `lend` takes."""
    if isinstance(value, tuple):
        return (type(value), *map(_description, value))
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.writeable, value.flags.aligned
    return type(value)


class _LentType(types.Type):
    def __init__(self, value: types.Type) -> None:
        self.value = value
        super().__init__(f"lent {value}")

    @property
    def key(self) -> types.Type:
        return self.value


@typeof_impl.register(Lent)
def _type_of_lent(lent: Lent[Any], context: Any) -> types.Type:
    return _LentType(lent.kind)


@register_model(_LentType)
class _Address(models.OpaqueModel):
    pass


@unbox(_LentType)  # type: ignore[no-untyped-call]
def _address_of(kind: Any, lent: Any, context: Any) -> Any:
    number = context.pyapi.object_getattr_string(lent, "address")
    address = context.pyapi.long_as_voidptr(number)
    context.pyapi.decref(number)
    return NativeValue(address)  # type: ignore[no-untyped-call]


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

    def taken(lent: Lent[_Lent]) -> _Lent:
        """Return the value that was lent, without counters; only in compiled code."""


@intrinsic
def _recalled(typing_context: Any, words: Any, like: Any) -> Any:
    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        row = context.make_array(words)(context, builder, arguments[0])
        return _rebuilt(context, builder, like, row.data)

    return like(words, like), lower


@intrinsic
def _taken(typing_context: Any, lent: Any) -> Any:
    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        word = context.get_value_type(types.int64)
        return _rebuilt(
            context, builder, lent.value, builder.bitcast(arguments[0], word.as_pointer())
        )

    return lent.value(lent), lower


if not TYPE_CHECKING:
    recalled, taken = _recalled, _taken


def _rebuilt(context: Any, builder: Any, kind: Any, words: Any) -> Any:
    place = count()

    def take() -> Any:
        at = context.get_constant(types.intp, next(place))
        return builder.load(builder.gep(words, [at]))

    return _part(context, builder, kind, take)


def _part(context: Any, builder: Any, kind: Any, take: Any) -> Any:
    if isinstance(kind, types.BaseTuple):
        known: Any = kind
        parts = [_part(context, builder, part, take) for part in known.types]
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
