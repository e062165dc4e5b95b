"""SIMD: vectors of sixteen float32 or int32 in compiled code, with the same bits everywhere.

LLVM vectorises a float sum only where it may reorder it (`fastmath`), and differently for each
register width. Here the lanes are explicit: a sum is kept in sixteen partial sums, which are added
in a fixed order, so a processor with narrow registers takes more instructions and gets the same
bits. Inside `njit` functions `+ - * /` work on two F32x16 (`f32x16(x)` broadcasts a scalar), and
`+ * & >>` on two I32x16. None of these functions can be called outside compiled code. Their types
for mypy are in simd.pyi; the internals of Numba that they need are in numba_internals.py.
"""

import operator
from typing import Any

from seamark.sim.numerics.numba_internals import require_simd

require_simd()

from llvmlite import ir  # noqa: E402  # what follows fails without a sentence if internals lack
from numba.core import cgutils, types  # noqa: E402
from numba.core.imputils import lower_builtin  # noqa: E402
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature  # noqa: E402
from numba.extending import intrinsic, models, register_model  # noqa: E402

WIDTH = 16
ALL_LANES = (1 << WIDTH) - 1  # bits, as of `greater_bits`
_FLOAT, _INT = ir.FloatType(), ir.IntType(32)
_FLOATS, _INTS = ir.VectorType(_FLOAT, WIDTH), ir.VectorType(_INT, WIDTH)


class _F32x16Type(types.Type):
    def __init__(self) -> None:
        super().__init__(name="F32x16")


class _I32x16Type(types.Type):
    def __init__(self) -> None:
        super().__init__(name="I32x16")


_f32x16, _i32x16 = _F32x16Type(), _I32x16Type()


@register_model(_F32x16Type)
class _F32x16Model(models.PrimitiveModel):
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, _FLOATS)


@register_model(_I32x16Type)
class _I32x16Model(models.PrimitiveModel):
    def __init__(self, manager: Any, numba_type: Any) -> None:
        super().__init__(manager, numba_type, _INTS)


def _operation(symbol: Any, vector: types.Type, instruction: str) -> None:
    @infer_global(symbol)
    class _Template(ConcreteTemplate):
        cases = (signature(vector, vector, vector),)

    @lower_builtin(symbol, vector, vector)
    def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)


for _symbol, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operation(_symbol, _f32x16, _instruction)
for _symbol, _instruction in (
    (operator.add, "add"),
    (operator.mul, "mul"),
    (operator.and_, "and_"),
    (operator.rshift, "lshr"),
):
    _operation(_symbol, _i32x16, _instruction)


def _broadcast(builder: Any, scalar: Any, vector: Any) -> Any:
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


def _is_matrix(array: types.Type) -> bool:
    return isinstance(array, types.Array) and array.ndim == 2 and array.layout == "C"


def _is_row(array: types.Type, dtype: types.Type) -> bool:
    one = isinstance(array, types.Array) and array.ndim == 1 and array.layout == "C"
    return one and array.dtype == dtype


@intrinsic
def f32x16(typing: Any, scalar: Any) -> Any:
    """Return a vector with a float32 in every lane; a wider number is rounded first."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = context.cast(builder, args[0], sig.args[0], types.float32)
        return _broadcast(builder, value, _FLOATS)

    return _f32x16(scalar), generate


@intrinsic
def i32x16(typing: Any, scalar: Any) -> Any:
    """Return a vector with an int32 in every lane."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = context.cast(builder, args[0], sig.args[0], types.int32)
        return _broadcast(builder, value, _INTS)

    return _i32x16(scalar), generate


@intrinsic
def load(typing: Any, array: Any, row: Any, column: Any) -> Any:
    """Return array[row, column : column + 16] of float32, without a bounds check."""
    if not _is_matrix(array) or array.dtype != types.float32:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig, args)
        value = builder.load(builder.bitcast(address, _FLOATS.as_pointer()))
        value.align = 4
        return value

    return _f32x16(array, row, column), generate


@intrinsic
def store(typing: Any, array: Any, row: Any, column: Any, value: Any) -> Any:
    """Set array[row, column : column + 16] of float32, without a bounds check."""
    if not _is_matrix(array) or array.dtype != types.float32 or value != _f32x16:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = _address(context, builder, sig, args)
        builder.store(args[3], builder.bitcast(address, _FLOATS.as_pointer())).align = 4
        return context.get_dummy_value()

    return types.void(array, row, column, value), generate


def _selection(comparison: str) -> Any:
    def typed(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            first = builder.fcmp_ordered(comparison, *args)
            return builder.select(first, *args)

        return (_f32x16(a, b), generate) if a == b == _f32x16 else None

    return typed


maximum = intrinsic(_selection(">"))  # lane by lane; the second operand where one of them is NaN
minimum = intrinsic(_selection("<"))


@intrinsic
def select_greater(typing: Any, a: Any, b: Any, then: Any, otherwise: Any) -> Any:
    """Return `then` in the lanes where a > b, `otherwise` in the others."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", args[0], args[1]), args[2], args[3])

    if not a == b == then == otherwise == _f32x16:
        return None
    return _f32x16(a, b, then, otherwise), generate


@intrinsic
def greater_bits(typing: Any, a: Any, b: Any) -> Any:
    """Return which lanes have a > b as the bits of an integer, that of lane 0 lowest."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        lanes = builder.bitcast(builder.fcmp_ordered(">", *args), ir.IntType(WIDTH))
        return builder.zext(lanes, ir.IntType(64))

    return (types.int64(a, b), generate) if a == b == _f32x16 else None


@intrinsic
def to_i32(typing: Any, value: Any) -> Any:
    """Return float32 lanes truncated to int32; they must be finite and in its range."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.fptosi(args[0], _INTS)

    return (_i32x16(value), generate) if value == _f32x16 else None


@intrinsic
def to_f32(typing: Any, value: Any) -> Any:
    """Return int32 lanes converted to float32."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.sitofp(args[0], _FLOATS)

    return (_f32x16(value), generate) if value == _i32x16 else None


@intrinsic
def all_alike(typing: Any, value: Any) -> Any:
    """Return whether all lanes are the same, as a boolean."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        first = builder.extract_element(args[0], _INT(0))
        same = builder.icmp_signed("==", args[0], _broadcast(builder, first, _INTS))
        lanes = ir.IntType(WIDTH)
        all_same = builder.icmp_signed("==", builder.bitcast(same, lanes), lanes(ALL_LANES))
        return context.cast(builder, all_same, types.boolean, sig.return_type)

    return (types.boolean(value), generate) if value == _i32x16 else None


@intrinsic
def load_pairs(typing: Any, array: Any, first: Any, at: Any, column: Any, alike: Any) -> Any:
    """Return sixteen pairs of neighbours in an array of uint8 or uint16, as int32 lanes.

    Each is the element at flat index first + at[k], in the low bits, and the next one, for k from
    column on; `at` is of int32 (n,). If these are all `alike`, only one pair is loaded.
    """
    if not _is_matrix(array) or array.dtype not in (types.uint8, types.uint16):
        return None
    pair = ir.IntType(2 * array.dtype.bitwidth)
    lanes = ir.VectorType(pair, WIDTH)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data, indices = (
            context.make_array(sig.args[k])(context, builder, args[k]).data for k in (0, 2)
        )
        first, column = (context.cast(builder, args[k], sig.args[k], types.intp) for k in (1, 3))
        data = builder.gep(data, [first])

        def one(k: int) -> Any:
            place = builder.add(column, context.get_constant(types.intp, k))
            index = builder.sext(builder.load(builder.gep(indices, [place])), place.type)
            return builder.load(
                builder.bitcast(builder.gep(data, [index]), pair.as_pointer()), align=1
            )

        value = cgutils.alloca_once(builder, lanes)
        with builder.if_else(args[4]) as (then, otherwise):
            with then:
                builder.store(_broadcast(builder, one(0), lanes), value)
            with otherwise:
                each = ir.Constant(lanes, ir.Undefined)
                for k in range(WIDTH):
                    each = builder.insert_element(each, one(k), _INT(k))
                builder.store(each, value)
        pairs = builder.load(value)
        return pairs if pair.width == _INT.width else builder.zext(pairs, _INTS)

    return _i32x16(array, first, at, column, types.boolean), generate


@intrinsic
def sqrt(typing: Any, value: Any) -> Any:
    """Return the square roots of all lanes, correctly rounded (IEEE 754)."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function_type = ir.FunctionType(_FLOATS, (_FLOATS,))
        square_root = cgutils.get_or_insert_function(
            builder.module, function_type, "llvm.sqrt.v16f32"
        )
        return builder.call(square_root, args)

    return (_f32x16(value), generate) if value == _f32x16 else None


@intrinsic
def fma(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once (IEEE 754).

    Without such an instruction the C library computes each lane: the bits are the same.
    """
    if not a == b == c == _f32x16:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function_type = ir.FunctionType(_FLOATS, (_FLOATS, _FLOATS, _FLOATS))
        fused = cgutils.get_or_insert_function(builder.module, function_type, "llvm.fma.v16f32")
        return builder.call(fused, args)

    return _f32x16(a, b, c), generate


@intrinsic
def gather_pairs(typing: Any, array: Any, at: Any) -> Any:
    """Return sixteen elements of a uint16 array (n,) by index, each with the next one.

    The element is in the low bits of an int32 lane, its neighbour in the high ones; no index is
    checked. Without such an instruction they are loaded one by one: the bits are the same.
    """
    if not _is_row(array, types.uint16) or at != _i32x16:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        # llvmlite has no vectors of addresses: an instruction for one address gets sixteen indices.
        addresses = builder.gep(data, [_INT(0)])
        addresses.indices, addresses.type = [args[1]], ir.VectorType(data.type, WIDTH)
        all_lanes = ir.VectorType(ir.IntType(1), WIDTH)
        types_ = (_INTS, (addresses.type, _INT, all_lanes, _INTS))
        load_all = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(*types_), "llvm.masked.gather.v16i32.v16p0"
        )
        mask, otherwise = ir.Constant(all_lanes, [1] * WIDTH), ir.Constant(_INTS, ir.Undefined)
        return builder.call(load_all, [addresses, _INT(2), mask, otherwise])

    return _i32x16(array, at), generate


@intrinsic
def fetch_pairs(typing: Any, array: Any, at: Any, out: Any, column: Any) -> Any:
    """Set out[k] to what `gather_pairs` returns for at[k], for k from column on, sixteen of them.

    `array` is of uint16 (n,), `at` and `out` are of int32. The indices are not negative, and
    nothing checks them. Where many follow each other this is faster than `gather_pairs`, which many
    processors carry out element by element. A processor makes few accesses to memory in a cycle,
    however wide they are, so one reads two indices and one writes two results.
    """
    if not _is_row(array, types.uint16) or not _is_row(at, types.int32) or at != out:
        return None
    double, low = ir.IntType(64), ir.Constant(ir.IntType(64), 2**32 - 1)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        source, indices, target = (
            context.make_array(sig.args[k])(context, builder, args[k]).data for k in range(3)
        )
        first = context.cast(builder, args[3], sig.args[3], types.intp)

        def element(index: Any) -> Any:
            address = builder.bitcast(builder.gep(source, [index]), _INT.as_pointer())
            value = builder.load(address)
            value.align = 2
            return builder.zext(value, double)

        for k in range(0, WIDTH, 2):
            place = builder.add(first, context.get_constant(types.intp, k))
            two, address = (
                builder.bitcast(builder.gep(data, [place]), double.as_pointer())
                for data in (indices, target)
            )
            at_both = builder.load(two)
            at_both.align = 4
            left = element(builder.and_(at_both, low))
            right = element(builder.lshr(at_both, double(32)))
            both = builder.or_(left, builder.shl(right, double(32)))
            builder.store(both, address).align = 4
        return context.get_dummy_value()

    return types.void(array, at, out, column), generate


@intrinsic
def load_i32(typing: Any, array: Any, column: Any) -> Any:
    """Return array[column : column + 16] of int32 (n,), without a bounds check."""
    if not isinstance(array, types.Array) or (array.ndim, array.dtype) != (1, types.int32):
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = builder.load(_row_address(context, builder, sig, args))
        value.align = 4
        return value

    return _i32x16(array, column), generate


@intrinsic
def prefetch(typing: Any, array: Any, at: Any) -> Any:
    """Have the processor load array[at] of float32 (n,) into its L2 cache; changes nothing else."""
    if not isinstance(array, types.Array) or (array.ndim, array.dtype) != (1, types.float32):
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        offset = context.cast(builder, args[1], sig.args[1], types.intp)
        address = builder.bitcast(builder.gep(data, [offset]), ir.IntType(8).as_pointer())
        function_type = ir.FunctionType(ir.VoidType(), (address.type, _INT, _INT, _INT))
        fetch = cgutils.get_or_insert_function(builder.module, function_type, "llvm.prefetch.p0")
        reading, for_l2, data_cache = _INT(0), _INT(2), _INT(1)
        builder.call(fetch, [address, reading, for_l2, data_cache])
        return context.get_dummy_value()

    return types.void(array, at), generate


@intrinsic
def store_i32(typing: Any, array: Any, column: Any, value: Any) -> Any:
    """Set array[column : column + 16] of int32, without a bounds check."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _row_address(context, builder, sig, args)).align = 4
        return context.get_dummy_value()

    return (types.void(array, column, value), generate) if value == _i32x16 else None


@intrinsic
def store_u8(typing: Any, array: Any, column: Any, value: Any) -> Any:
    """Set array[column : column + 16] of uint8 (n,), without a bounds check.

    The lanes of the int32 vector must be within 0..255.
    """
    if not _is_row(array, types.uint8) or value != _i32x16:
        return None
    grey = ir.VectorType(ir.IntType(8), WIDTH)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        first = context.cast(builder, args[1], sig.args[1], types.intp)
        address = builder.bitcast(builder.gep(data, [first]), grey.as_pointer())
        builder.store(builder.trunc(args[2], grey), address).align = 1
        return context.get_dummy_value()

    return types.void(array, column, value), generate


@intrinsic
def horizontal_sum(typing: Any, value: Any) -> Any:
    """Return the sum over the lanes as float32: upper half onto lower half, until one is left."""

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

    return (types.float32(value), generate) if value == _f32x16 else None


@intrinsic
def horizontal_sums(typing: Any, array: Any, row: Any) -> Any:
    """Return `horizontal_sum` of sixteen rows of float32 (n, 16) from `row` on, a lane for each.

    The parts of several rows are added side by side in one vector, so a third of the instructions.
    """
    if not _is_matrix(array) or array.dtype != types.float32:
        return None

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        column = context.get_constant(types.intp, 0)
        types_ = types.void(*sig.args, types.intp)
        first = builder.bitcast(
            _address(context, builder, types_, (*args, column)), _FLOATS.as_pointer()
        )
        parts = [builder.load(builder.gep(first, [_INT(k)]), align=4) for k in range(WIDTH)]
        n = WIDTH // 2
        while n > 0:
            low = [lane for lane in range(2 * WIDTH) if not lane & n]
            pairs = zip(parts[::2], parts[1::2], strict=True)
            parts = [_add_lanes(builder, pair, low, n) for pair in pairs]
            n //= 2
        return parts[0]

    return _f32x16(array, row), generate


def _add_lanes(builder: Any, pair: Any, lanes: list[int], distance: int) -> Any:
    """Return lanes of two vectors, counted on from one to the other, plus those farther up."""
    low, high = (
        builder.shuffle_vector(*pair, ir.Constant(_INTS, [lane + off for lane in lanes]))
        for off in (0, distance)
    )
    return builder.fadd(low, high)
