"""Generated functions called for many states at once, by a loop that LLVM compiles."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from math import prod

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numpy.typing import NDArray

from fiv_cli.codegen.lower import target_machine
from fiv_cli.codegen.memory import WORD, address_of

REAL, WHOLE = ir.DoubleType(), ir.IntType(64)
ARRAY = REAL.as_pointer()
GENERATED = ir.FunctionType(ir.VoidType(), (ARRAY, REAL, ARRAY, ARRAY)).as_pointer()
# The function, time, the number of rows, how many share their coefficients; of coefficients,
# states and outputs each the address and the bytes from one row to the next.
LOOP = ir.FunctionType(ir.VoidType(), (WHOLE, REAL, *(WHOLE,) * 8))


def call_rows(
    address: int,
    coefficients: NDArray[np.float64],
    time: float,
    states: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Call the generated function at `address` for each state of an array (..., n_states).

    Coefficients that stand for several states, one after the other, are given once.
    """
    count = prod(states.shape[:-1])
    if count > 0:
        _loop()(
            address, time, count, count // prod(coefficients.shape[:-1]),
            address_of(coefficients), WORD * coefficients.shape[-1],
            address_of(states), states.nbytes // count,
            address_of(out), out.nbytes // count,
        )  # fmt: skip


@cache
def _loop() -> Callable[..., None]:
    """The compiled loop, as Python calls it."""
    # what the loop costs is nothing beside what it calls: the quickest compilation
    engine = llvm.create_mcjit_compiler(
        llvm.parse_assembly(str(_module())), target_machine(effort=0)
    )
    engine.finalize_object()
    kinds = [ctypes.c_double if kind == REAL else ctypes.c_int64 for kind in LOOP.args]
    loop = ctypes.CFUNCTYPE(None, *kinds)(engine.get_function_address("rows"))
    loop.engine = engine  # type: ignore[attr-defined]  # keeps the code alive
    return loop


def _module() -> ir.Module:
    module = ir.Module()
    rows = ir.Function(module, LOOP, "rows")
    function, time, count, shared, *arrays = rows.args
    begin, row, end = (rows.append_basic_block(name) for name in ("begin", "row", "end"))
    builder = ir.IRBuilder(begin)
    generated = builder.inttoptr(function, GENERATED)
    builder.branch(row)
    builder.position_at_end(row)
    number = builder.phi(WHOLE)
    places = builder.udiv(number, shared), number, number
    terms, state, out = (
        builder.inttoptr(builder.add(first, builder.mul(place, length)), ARRAY)
        for place, first, length in zip(places, arrays[::2], arrays[1::2], strict=True)
    )
    builder.call(generated, (terms, time, state, out))
    following = builder.add(number, WHOLE(1))
    number.add_incoming(WHOLE(0), begin)
    number.add_incoming(following, row)
    builder.cbranch(builder.icmp_unsigned("<", following, count), row, end)
    ir.IRBuilder(end).ret_void()
    return module
