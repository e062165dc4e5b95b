"""Lanes: eight float64 side by side, so that one function serves one vehicle or eight of them.

A compiled function of numbers and arrays works on lanes as it stands: Numba compiles it once more,
with lanes for a number and a view of (..., 8) for an array. Every lane gets the operations of the
single number in the same order, so the bits are the same. A branch cannot follow eight numbers at
once: such a function takes a value by `select`, and may skip what not even `some` lane needs.

Lanes have `+ - * / abs` and comparisons, also with a number; the masks that these give have `& |`.
None of these functions can be called outside compiled code. Their types for mypy are in lanes.pyi.
"""

import operator
from collections.abc import Callable
from typing import Any

from seamark.sim.numerics.numba_internals import require_simd

require_simd()

from llvmlite import ir  # noqa: E402  # what follows fails without a sentence if internals lack
from numba.core import cgutils, types  # noqa: E402
from numba.core.imputils import lower_builtin, lower_cast  # noqa: E402
from numba.core.typeconv import Conversion  # noqa: E402
from numba.core.typing.templates import (  # noqa: E402
    AbstractTemplate,
    AttributeTemplate,
    ConcreteTemplate,
    infer_getattr,
    infer_global,
    signature,
)
from numba.extending import intrinsic, lower_getattr, models, register_model  # noqa: E402

LANES = 8
_FRACTION, _BIAS = 52, 1023  # of a float64: bits of the fraction, bias of the exponent
_DOUBLE, _LONG, _BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
_DOUBLES, _LONGS, _BITS = (ir.VectorType(kind, LANES) for kind in (_DOUBLE, _LONG, _BIT))
_INDICES = ir.VectorType(ir.IntType(32), LANES)


class _LanesType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def can_convert_from(self, typing: Any, other: Any) -> Any:
        """Let a number stand for eight equal ones."""
        return Conversion.safe if isinstance(other, types.Float | types.Integer) else None


class _MaskType(types.Type):
    def __init__(self) -> None:
        super().__init__(name="LanesMask")


class _ViewType(types.Type):
    """A view of an array (k, 8) or (j, k, 8): its items are lanes."""

    def __init__(self, ndim: int) -> None:
        self.ndim = ndim
        super().__init__(name=f"LanesView{ndim}")


_lanes, _mask = _LanesType(), _MaskType()


def _register_vector(numba_type: type, vector: Any) -> None:
    @register_model(numba_type)
    class _Model(models.PrimitiveModel):
        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, vector)


for _type, _vector in ((_LanesType, _DOUBLES), (_MaskType, _BITS)):
    _register_vector(_type, _vector)


@register_model(_ViewType)
class _ViewModel(models.StructModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        members = [("data", types.CPointer(types.float64))]
        members += [(f"size{axis}", types.intp) for axis in range(kind.ndim)]
        super().__init__(manager, kind, members)


def _broadcast(builder: Any, scalar: Any, vector: Any) -> Any:
    empty = ir.Constant(vector, ir.Undefined)
    one = builder.insert_element(empty, scalar, ir.IntType(32)(0))
    return builder.shuffle_vector(one, empty, ir.Constant(_INDICES, [0] * LANES))


@lower_cast(types.Float, _LanesType)
@lower_cast(types.Integer, _LanesType)
def _fill(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    number = context.cast(builder, value, source, types.float64)
    return _broadcast(builder, number, _DOUBLES)


def _operation(symbol: Any, cases: tuple[Any, ...], emit: Callable[..., Any]) -> None:
    @infer_global(symbol)
    class _Template(ConcreteTemplate):
        pass

    _Template.cases = cases
    for case in cases:

        @lower_builtin(symbol, *case.args)
        def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, *args)


def _instruction(name: str) -> Callable[..., Any]:
    return lambda builder, *args: getattr(builder, name)(*args)


def _comparison(symbol: str) -> Callable[..., Any]:
    if symbol == "!=":
        return lambda builder, a, b: builder.fcmp_unordered(symbol, a, b)
    return lambda builder, a, b: builder.fcmp_ordered(symbol, a, b)


def _llvm(name: str) -> Callable[..., Any]:
    """Return what calls an LLVM intrinsic of one number or of lanes."""

    def emit(builder: Any, value: Any) -> Any:
        suffix = "f64" if value.type == _DOUBLE else "v8f64"
        kind = ir.FunctionType(value.type, (value.type,))
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.{suffix}")
        return builder.call(function, [value])

    return emit


_BINARY = (signature(_lanes, _lanes, _lanes),)
for _symbol, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
    (operator.iadd, "fadd"),
    (operator.isub, "fsub"),
    (operator.imul, "fmul"),
    (operator.itruediv, "fdiv"),
):
    _operation(_symbol, _BINARY, _instruction(_name))
for _symbol, _name in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
    (operator.ne, "!="),
):
    _operation(_symbol, (signature(_mask, _lanes, _lanes),), _comparison(_name))
_operation(operator.and_, (signature(_mask, _mask, _mask),), _instruction("and_"))
_operation(operator.or_, (signature(_mask, _mask, _mask),), _instruction("or_"))
_operation(operator.neg, (signature(_lanes, _lanes),), _instruction("fneg"))
_operation(abs, (signature(_lanes, _lanes),), _llvm("fabs"))


@infer_global(operator.getitem)
class _GetItem(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        view, index = args
        return signature(_lanes, view, index) if _indexes(view, index) else None


@infer_global(operator.setitem)
class _SetItem(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        view, index, _value = args
        return signature(types.void, view, index, _lanes) if _indexes(view, index) else None


def _indexes(view: Any, index: Any) -> bool:
    if not isinstance(view, _ViewType):
        return False
    parts = tuple(index) if isinstance(index, types.BaseTuple) else (index,)
    return len(parts) == view.ndim and all(isinstance(part, types.Integer) for part in parts)


def _address(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind, index = sig.args[0], sig.args[1]
    view = cgutils.create_struct_proxy(kind)(context, builder, value=args[0])
    parts, kinds = [args[1]], [index]
    if isinstance(index, types.BaseTuple):
        parts, kinds = cgutils.unpack_tuple(builder, args[1]), list(index)
    parts = [context.cast(builder, *pair, types.intp) for pair in zip(parts, kinds, strict=True)]
    offset = parts[0]
    for axis in range(1, kind.ndim):
        offset = builder.add(builder.mul(offset, getattr(view, f"size{axis}")), parts[axis])
    first = builder.gep(view.data, [builder.mul(offset, _LONG(LANES))])
    return builder.bitcast(first, _DOUBLES.as_pointer())


@lower_builtin(operator.getitem, _ViewType, types.Any)
def _load(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    value = builder.load(_address(context, builder, sig, args))
    value.align = 8
    return value


@lower_builtin(operator.setitem, _ViewType, types.Any, _LanesType)
def _store(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    builder.store(args[2], _address(context, builder, sig, args)).align = 8
    return context.get_dummy_value()


@infer_getattr
class _ViewAttributes(AttributeTemplate):
    key = _ViewType

    def resolve_size(self, view: Any) -> Any:
        return types.intp if view.ndim == 1 else None

    def resolve_shape(self, view: Any) -> Any:
        return types.UniTuple(types.intp, view.ndim)


@lower_getattr(_ViewType, "size")
def _size(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return cgutils.create_struct_proxy(kind)(context, builder, value=value).size0


@lower_getattr(_ViewType, "shape")
def _shape(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    view = cgutils.create_struct_proxy(kind)(context, builder, value=value)
    sizes = [getattr(view, f"size{axis}") for axis in range(kind.ndim)]
    return context.make_tuple(builder, types.UniTuple(types.intp, kind.ndim), sizes)


@intrinsic
def lanes_of(typing: Any, value: Any) -> Any:
    """Return a view of a float64 array (..., 8); whoever owns the memory must outlive it.

    Of a tuple, also a nested one, it returns a tuple with views in place of such arrays; what is
    not an array of float64 is the same for all lanes and stays.
    """
    if not isinstance(value, types.BaseTuple) and not _has_lanes(value):
        return None
    kind = _kind_of_view(value)

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _view_of(context, builder, value, args[0])

    return kind(value), generate


def _has_lanes(kind: Any) -> bool:
    array = isinstance(kind, types.Array)
    return array and kind.layout == "C" and kind.dtype == types.float64


def _kind_of_view(kind: Any) -> Any:
    if isinstance(kind, types.BaseTuple):
        parts = [_kind_of_view(part) for part in kind]
        if isinstance(kind, types.BaseNamedTuple):
            return types.NamedTuple(parts, kind.instance_class)
        return types.Tuple(parts)
    return _ViewType(kind.ndim - 1) if _has_lanes(kind) else kind


def _view_of(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, types.BaseTuple):
        parts = [
            _view_of(context, builder, part, builder.extract_value(value, at))
            for at, part in enumerate(kind)
        ]
        return context.make_tuple(builder, _kind_of_view(kind), parts)
    if not _has_lanes(kind):
        context.nrt.incref(builder, kind, value)
        return value
    view = _kind_of_view(kind)
    given = context.make_array(kind)(context, builder, value)
    made = cgutils.create_struct_proxy(view)(context, builder)
    made.data = given.data
    for axis, size in enumerate(cgutils.unpack_tuple(builder, given.shape)[: view.ndim]):
        setattr(made, f"size{axis}", size)
    return made._getvalue()


def _either(number: Any, lanes: Any, emit: Callable[..., Any]) -> Any:
    """Return the typing of a function from one number to `number`, from lanes to `lanes`."""

    def typed(typing: Any, value: Any) -> Any:
        if value != _lanes and not isinstance(value, types.Float):
            return None

        def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return emit(builder, args[0])

        return (lanes(_lanes) if value == _lanes else number(types.float64)), generate

    return typed


sqrt = intrinsic(_either(types.float64, _lanes, _llvm("sqrt")))
floor = intrinsic(_either(types.float64, _lanes, _llvm("floor")))


@intrinsic
def select(typing: Any, condition: Any, then: Any, otherwise: Any) -> Any:
    """Return `then` where the condition holds and `otherwise` elsewhere."""
    kind = _lanes if condition == _mask else types.float64

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(*args)

    return kind(_mask if kind == _lanes else types.boolean, kind, kind), generate


@intrinsic
def some(typing: Any, condition: Any) -> Any:
    """Return whether the condition holds in some lane; of one number, the condition itself."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if condition != _mask:
            return args[0]
        bits = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(_mask if condition == _mask else types.boolean), generate


@intrinsic
def like(typing: Any, value: Any, number: Any) -> Any:
    """Return a number in the form of a value: itself, or as lanes."""
    kind = _lanes if value == _lanes else types.float64

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return args[1]

    return kind(kind, kind), generate


def _of_bits(emit: Callable[..., Any]) -> Callable[..., Any]:
    """Return what works on a number, or on lanes, and on constants of their integer type."""

    def whole(builder: Any, value: Any) -> Any:
        kind = _LONG if value.type == _DOUBLE else _LONGS

        def constant(number: int) -> Any:
            return ir.Constant(kind, number if kind == _LONG else [number] * LANES)

        return emit(builder, value, kind, constant)

    return whole


@_of_bits
def _emit_power(builder: Any, value: Any, kind: Any, constant: Callable[[int], Any]) -> Any:
    biased = builder.add(builder.fptosi(value, kind), constant(_BIAS))
    return builder.bitcast(builder.shl(biased, constant(_FRACTION)), value.type)


@_of_bits
def _emit_exponent(builder: Any, value: Any, kind: Any, constant: Callable[[int], Any]) -> Any:
    biased = builder.lshr(builder.bitcast(value, kind), constant(_FRACTION))
    return builder.sitofp(builder.sub(biased, constant(_BIAS - 1)), value.type)


@_of_bits
def _emit_mantissa(builder: Any, value: Any, kind: Any, constant: Callable[[int], Any]) -> Any:
    fraction = builder.and_(builder.bitcast(value, kind), constant((1 << _FRACTION) - 1))
    half = constant((_BIAS - 1) << _FRACTION)
    return builder.bitcast(builder.or_(fraction, half), value.type)


# 2**k of a whole number k from -1022 to 1023; and x = mantissa 2**exponent with a mantissa from 0.5
# to 1, as of `math.frexp`, for a normal x > 0.
power_of_two = intrinsic(_either(types.float64, _lanes, _emit_power))
exponent = intrinsic(_either(types.float64, _lanes, _emit_exponent))
mantissa = intrinsic(_either(types.float64, _lanes, _emit_mantissa))
