"""What compiled code needs below the level of Python: calls by address, plain reads.

All generated functions share one signature ``(c, t, y, out)``. The driver is compiled once and
takes addresses as plain integers, so it knows nothing of models and is never compiled again.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def call_generated(  # type: ignore[no-untyped-def]
    typing_context, address, coefficients, time, state, out
):
    """Call the function at `address` with the data of the arrays."""
    signature = types.void(address, coefficients, time, state, out)

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        double = ir.DoubleType()
        pointer = double.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), (pointer, double, pointer, pointer))
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        data = {
            i: cgutils.create_struct_proxy(signature.args[i])(
                context, builder, value=arguments[i]
            ).data
            for i in (1, 3, 4)
        }
        builder.call(function, (data[1], arguments[2], data[3], data[4]))
        return context.get_dummy_value()

    return signature, build


@intrinsic
def at(typing_context, array, index):  # type: ignore[no-untyped-def]
    """``array[index]`` of a flat array where the index is known not to be negative.

    Indexing by a signed number asks each time whether it counts from the end: half the work of
    summing a series.
    """
    signature = array.dtype(array, types.int64)

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        view = cgutils.create_struct_proxy(signature.args[0])(context, builder, value=arguments[0])
        return builder.load(builder.gep(view.data, [arguments[1]]))

    return signature, build
