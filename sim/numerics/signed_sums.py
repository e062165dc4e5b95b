"""Sums of an array's elements by a table, compiled to code without loops and look-ups."""

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

_DOUBLE = ir.DoubleType()


def signed_sums(table: Any) -> Any:
    """Return a function (values, out), for compiled code alone, that writes out[k] for each k.

    It is zero plus or minus the elements of `values` that the table lists for k, each with its
    sign, in that order; indices are flat. A loop over the table takes several times as long, since
    it reads and writes a sum for each term.
    """

    def typed(typing: Any, values: Any, out: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            source, target = (
                context.make_array(kind)(context, builder, array).data
                for kind, array in zip(sig.args, args, strict=True)
            )
            word = context.get_value_type(types.intp)
            used = {at for terms in table.values() for at, _ in terms}
            value = {at: builder.load(builder.gep(source, [word(at)])) for at in sorted(used)}
            for k, terms in table.items():
                total = _DOUBLE(0.0)
                for at, sign in terms:
                    total = (builder.fadd if sign > 0 else builder.fsub)(total, value[at])
                builder.store(total, builder.gep(target, [word(k)]))
            return context.get_dummy_value()

        if not all(
            isinstance(array, types.Array) and (array.dtype, array.layout) == (types.float64, "C")
            for array in (values, out)
        ):
            return None
        return types.void(values, out), generate

    return intrinsic(typed)
