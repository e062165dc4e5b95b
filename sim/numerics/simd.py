"""Sixteen float32 side by side as one value in compiled code: fast, and the same bits everywhere.

LLVM vectorises a float sum only where it may reorder it (`fastmath`), differently for each width of
the processor's registers. Here the lanes are written out: sums are kept in sixteen fixed parts and
added in a fixed order, so a processor with narrow registers takes more instructions and gets the
same bits. Inside `njit` functions `+ - * /` work on `Lanes`, and on `Lanes` alone: `lanes(x)` makes
one of a scalar. None of these functions can be called outside compiled code. Their
types for mypy are in lanes.pyi.
"""

import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

WIDTH = 16
_FLOAT, _INT = ir.FloatType(), ir.IntType(32)
_FLOATS, _INTS = ir.VectorType(_FLOAT, WIDTH), ir.VectorType(_INT, WIDTH)


class _LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")


class _PlacesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Places")


_lanes, _places = _LanesType(), _PlacesType()


@register_model(_LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _FLOATS)


@register_model(_PlacesType)
class _PlacesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _INTS)


def _operation(symbol: Any, kind: types.Type, instruction: str) -> None:
    @infer_global(symbol)
    class _Template(ConcreteTemplate):
        cases = (signature(kind, kind, kind),)

    @lower_builtin(symbol, kind, kind)
    def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)


for _symbol, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operation(_symbol, _lanes, _instruction)
for _symbol, _instruction in (
    (operator.add, "add"),
    (operator.mul, "mul"),
    (operator.and_, "and_"),
    (operator.rshift, "lshr"),
):
    _operation(_symbol, _places, _instruction)


def _spread(builder: Any, scalar: Any, vector: Any) -> Any:
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), scalar, _INT(0))
    return builder.shuffle_vector(
        one, ir.Constant(vector, ir.Undefined), ir.Constant(_INTS, [0] * WIDTH)
    )


def _address(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return the address of array[row, column]."""
    array = context.make_array(sig.args[0])(context, builder, args[0])
    pitch = cgutils.unpack_tuple(builder, array.shape)[1]
    row, column = (context.cast(builder, args[k], sig.args[k], types.intp) for k in (1, 2))
    return builder.gep(array.data, [builder.add(builder.mul(row, pitch), column)])


def _row_address(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return the address of sixteen int32 from array[column] on."""
    data = context.make_array(sig.args[0])(context, builder, args[0]).data
    column = context.cast(builder, args[1], sig.args[1], types.intp)
    return builder.bitcast(builder.gep(data, [column]), _INTS.as_pointer())


def _plane(array: types.Type) -> bool:
    return isinstance(array, types.Array) and array.ndim == 2 and array.layout == "C"


@intrinsic
def lanes(typing: Any, scalar: Any) -> Any:
    """Return a float32 in every lane; a wider number is rounded first."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = context.cast(builder, args[0], sig.args[0], types.float32)
        return _spread(builder, value, _FLOATS)

    return _lanes(scalar), generate


@intrinsic
def places(typing: Any, scalar: Any) -> Any:
    """Return an int32 in every lane."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = context.cast(builder, args[0], sig.args[0], types.int32)
        return _spread(builder, value, _INTS)

    return _places(scalar), generate


@intrinsic
def load(typing: Any, array: Any, row: Any, column: Any) -> Any:
    """Return array[row, column : column + 16] of float32; nothing checks that it is there."""
    if not _plane(array) or array.dtype != types.float32:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig, args)
        value = builder.load(builder.bitcast(address, _FLOATS.as_pointer()))
        value.align = 4
        return value

    return _lanes(array, row, column), generate


@intrinsic
def store(typing: Any, array: Any, row: Any, column: Any, value: Any) -> Any:
    """Set array[row, column : column + 16] of float32; nothing checks that it is there."""
    if not _plane(array) or array.dtype != types.float32 or value != _lanes:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig, args)
        builder.store(args[3], builder.bitcast(address, _FLOATS.as_pointer())).align = 4
        return context.get_dummy_value()

    return types.void(array, row, column, value), generate


def _choice(comparison: str) -> Any:
    def typed(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            first = builder.fcmp_ordered(comparison, *args)
            return builder.select(first, *args)

        return (_lanes(a, b), generate) if a == b == _lanes else None

    return typed


larger = intrinsic(_choice(">"))  # of two, lane by lane; the second where one is not a number
smaller = intrinsic(_choice("<"))


@intrinsic
def where_larger(typing: Any, a: Any, b: Any, then: Any, otherwise: Any) -> Any:
    """Return `then` in the lanes where a > b, and `otherwise` in the others."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", args[0], args[1]), args[2], args[3])

    if not a == b == then == otherwise == _lanes:
        return None
    return _lanes(a, b, then, otherwise), generate


@intrinsic
def whole(typing: Any, value: Any) -> Any:
    """Return lanes cut to int32; they must be numbers within its range."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.fptosi(args[0], _INTS)

    return (_places(value), generate) if value == _lanes else None


@intrinsic
def real(typing: Any, value: Any) -> Any:
    """Return int32 lanes as float32."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.sitofp(args[0], _FLOATS)

    return (_lanes(value), generate) if value == _places else None


@intrinsic
def pair(typing: Any, array: Any, at: Any) -> Any:
    """Return the element of an array at a flat place and the one after it, as one uint32.

    The array is of uint8 or uint16: one load of twice the size, the first element in the low bits.
    """
    if not _plane(array) or array.dtype not in (types.uint8, types.uint16):
        return None
    bits = array.dtype.bitwidth

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        place = context.cast(builder, args[1], sig.args[1], types.intp)
        address = builder.bitcast(builder.gep(data, [place]), ir.IntType(2 * bits).as_pointer())
        value = builder.load(address)
        value.align = 1
        return value if 2 * bits == _INT.width else builder.zext(value, _INT)

    return types.uint32(array, at), generate


@intrinsic
def part(typing: Any, words: Any, row: Any, column: Any, shift: Any, bits: Any) -> Any:
    """Return a part of each of sixteen uint32 from words[row, column] on, as lanes.

    The part is of that many bits, at most 16, and starts at bit `shift`.
    """
    if not _plane(words) or words.dtype != types.uint32:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig, args)
        found = builder.load(builder.bitcast(address, _INTS.as_pointer()))
        found.align = 4
        by, size = (context.cast(builder, args[k], sig.args[k], types.int32) for k in (3, 4))
        one = ir.Constant(_INT, 1)
        mask = builder.sub(builder.shl(one, size), one)
        moved = builder.lshr(found, _spread(builder, by, _INTS))
        return builder.sitofp(builder.and_(moved, _spread(builder, mask, _INTS)), _FLOATS)

    return _lanes(words, row, column, shift, bits), generate


@intrinsic
def root(typing: Any, value: Any) -> Any:
    """Return the square roots of lanes, rounded as IEEE 754 says."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(_FLOATS, (_FLOATS,))
        square_root = cgutils.get_or_insert_function(builder.module, kind, "llvm.sqrt.v16f32")
        return builder.call(square_root, args)

    return (_lanes(value), generate) if value == _lanes else None


@intrinsic
def fma(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once, as IEEE 754 says.

    A processor without such an instruction has the C library do each lane: the bits are the same.
    """
    if not a == b == c == _lanes:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(_FLOATS, (_FLOATS, _FLOATS, _FLOATS))
        fused = cgutils.get_or_insert_function(builder.module, kind, "llvm.fma.v16f32")
        return builder.call(fused, args)

    return _lanes(a, b, c), generate


@intrinsic
def gather(typing: Any, array: Any, at: Any) -> Any:
    """Return sixteen elements of an int32 array (n,) at places; nothing checks that they are there.

    A processor without such an instruction loads them one by one: the bits are the same.
    """
    if not isinstance(array, types.Array) or (array.ndim, array.dtype) != (1, types.int32):
        return None
    if array.layout != "C" or at != _places:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        # llvmlite knows no vectors of addresses: one is made, and then given sixteen places.
        addresses = builder.gep(data, [_INT(0)])
        addresses.indices, addresses.type = [args[1]], ir.VectorType(data.type, WIDTH)
        all_lanes = ir.VectorType(ir.IntType(1), WIDTH)
        kinds = (_INTS, (addresses.type, _INT, all_lanes, _INTS))
        load_all = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(*kinds), "llvm.masked.gather.v16i32.v16p0"
        )
        mask, otherwise = ir.Constant(all_lanes, [1] * WIDTH), ir.Constant(_INTS, ir.Undefined)
        return builder.call(load_all, [addresses, _INT(4), mask, otherwise])

    return _places(array, at), generate


@intrinsic
def store_places(typing: Any, array: Any, column: Any, value: Any) -> Any:
    """Set array[column : column + 16] of int32; nothing checks that it is there."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _row_address(context, builder, sig, args)).align = 4
        return context.get_dummy_value()

    return (types.void(array, column, value), generate) if value == _places else None


@intrinsic
def total(typing: Any, value: Any) -> Any:
    """Return the sum over the lanes as float32: halves upon halves, always in this order."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        part, n = args[0], WIDTH
        while n > 1:
            n //= 2
            empty = ir.Constant(part.type, ir.Undefined)
            low, high = (
                builder.shuffle_vector(
                    part, empty, ir.Constant(ir.VectorType(_INT, n), list(range(k, k + n)))
                )
                for k in (0, n)
            )
            part = builder.fadd(low, high)
        return builder.extract_element(part, _INT(0))

    return (types.float32(value), generate) if value == _lanes else None
