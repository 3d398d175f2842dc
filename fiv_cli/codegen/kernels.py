"""Kernels to machine code, by numba: what it has to be told of frames, views and generated code.

A kernel is a function marked `native` or `inlined`. It stays plain Python and gives the same bits
there: numba is asked for no fast-math, which excludes contraction too, and for numpy's divisions,
where a quotient by zero is infinite or NaN.

A *view* is where the data of an array begin and its lengths, nothing that counts references.
Indices are never counted from the end and nothing checks them.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Sequence
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from llvmlite import ir
from numba import cfunc, config, types
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    overload,
    overload_attribute,
    register_model,
    type_callable,
)

from fiv_cli.codegen.memory import (
    WORD,
    Field,
    Frame,
    Kind,
    bits_of,
    call_driver,
    call_generated,
    float_of,
    floats_at,
)

if TYPE_CHECKING:
    from llvmlite.ir import Instruction, IRBuilder, Value

    Kernel = Callable[..., object]
    Values = Sequence[Value]

OPTIONS = {"error_model": "numpy"}
SCALARS = {"float": types.float64, "int": types.int64, "bool": types.boolean}
ELEMENTS = {float: types.float64, int: types.int64}
DOUBLE, INTEGER = ir.DoubleType(), ir.IntType(64)
GENERATED = ir.FunctionType(
    ir.VoidType(), (DOUBLE.as_pointer(), DOUBLE, DOUBLE.as_pointer(), DOUBLE.as_pointer())
)

DRIVER = ir.FunctionType(INTEGER, (INTEGER, DOUBLE, DOUBLE, ir.IntType(8)))


class Signature(Protocol):
    """The types of a call, as numba gives them to those who lower it."""

    args: Sequence[types.Type]
    return_type: types.Type


class Context(Protocol):
    """What numba lends to those who lower a call, as far as they use it here."""

    def cast(self, builder: IRBuilder, value: Value, kind: types.Type, to: types.Type) -> Value: ...

    def get_value_type(self, kind: types.Type) -> ir.Type: ...

    def get_dummy_value(self) -> Value: ...

    def make_tuple(self, builder: IRBuilder, kind: types.Type, values: Values) -> Value: ...

    def make_helper(self, builder: IRBuilder, kind: types.Type, value: Value) -> Any: ...


# What an entry calls where a kernel raises, which none does, and numba alone provides.
RAISING = re.compile(r"^declare (.* @(?:numba|NRT)_\w+\(.*\)).*$", re.MULTILINE)
# Of loops that clear a few numbers LLVM would make calls of memset: a tenth of a run of the belt.
BEGINNING = re.compile(r"^(define .*) \{$", re.MULTILINE)


def text_of(entry: Kernel, signature: str, name: str) -> str:
    """LLVM text of an entry called `name`, as C calls it, and of all that it needs of numba.

    numba is kept from optimising it, function by function: what takes it up does that as a whole.
    """
    level, config.OPT = config.OPT, type(config.OPT)(0)
    try:
        made = cfunc(signature, **OPTIONS)(entry)
    finally:
        config.OPT = level
    text = RAISING.sub(r"define \1 { call void @llvm.trap() unreachable }", made.inspect_llvm())
    whole = BEGINNING.sub(r'\1 "no-builtin-memset" {', text)
    return whole.replace(made.native_name, name) + "declare void @llvm.trap()\n"


@cache
def register(module: ModuleType) -> None:
    """Let kernels call those of a module."""
    for function in vars(module).values():
        if hasattr(function, "__native__") and function.__module__ == module.__name__:
            _register_kernel(function)


def _register_kernel(kernel: Kernel) -> None:
    """Let kernels call this one, with what its annotations say and nothing else.

    numba would compile it once more for a call with an integer where it says float.
    """
    parameters = list(kernel.__annotations__.values())[: kernel.__code__.co_argcount]
    scalars = [SCALARS.get(annotation) for annotation in parameters]

    def chosen(*given: types.Type) -> Kernel | None:
        pairs = zip(given, scalars, strict=True)
        return kernel if all(scalar in (None, kind) for kind, scalar in pairs) else None

    inline = "always" if hasattr(kernel, "__inlined__") else "never"
    overload(kernel, jit_options=OPTIONS, strict=False, inline=inline)(chosen)


class View(types.Type):
    """An array in a kernel: its first word is where the data begin, its lengths follow."""

    def __init__(self, element: types.Type, depth: int) -> None:
        self.element, self.depth = element, depth
        super().__init__(name=f"View({element}, {depth})")


class FrameType(types.Record):
    """A frame in a kernel: a record at an address, with views for arrays."""

    dtype = np.dtype(np.void)  # numpy has no such record

    def __init__(self, frame: type[Frame]) -> None:
        self.frame = frame
        fields = [
            (name, {"type": _type_of_field(field.kind), "offset": WORD * field.place})
            for name, field in frame.fields.items()
        ]
        super().__init__(fields, WORD * frame.length, True)


def _type_of_field(kind: Kind) -> types.Type:
    element = ELEMENTS[kind.element]
    return View(element, kind.depth) if kind.depth else element


register_model(FrameType)(models.OpaqueModel)


@register_model(View)
class _ViewModel(models.StructModel):
    def __init__(self, manager: object, view: View) -> None:
        lengths = [(f"length{level}", types.int64) for level in range(view.depth)]
        super().__init__(manager, view, [("data", types.CPointer(view.element)), *lengths])


# --- elements, rows, what follows an index --------------------------------------------------------
@type_callable(operator.getitem)
def _type_of_item(context: Context) -> Callable[..., types.Type | None]:
    def typed(view: types.Type, index: types.Type) -> types.Type | None:
        if not isinstance(view, View):
            return None
        if isinstance(index, types.SliceType):
            return view if view.depth == 1 else None
        left = view.depth - (len(index) if isinstance(index, types.BaseTuple) else 1)
        return View(view.element, left) if left > 0 else view.element

    return typed


@type_callable(operator.setitem)
def _type_of_setting(context: Context) -> Callable[..., types.Type | None]:
    def typed(view: types.Type, index: types.Type, value: types.Type) -> types.Type | None:
        return types.none if isinstance(view, View) else None

    return typed


def _place(
    context: Context, builder: IRBuilder, signature: Signature, given: Values
) -> tuple[Value, list[Value]]:
    """Where an element or a row is, and the lengths that are left of it."""
    (view, index_type), (value, index) = signature.args[:2], given[:2]
    indices, kinds = [index], [index_type]
    if isinstance(index_type, types.BaseTuple):
        kinds = list(index_type)
        indices = [builder.extract_value(index, i) for i in range(len(kinds))]
    data, *lengths = (builder.extract_value(value, i) for i in range(1 + view.depth))
    offset = None
    for level, length in enumerate(lengths):
        if offset is not None:
            offset = builder.mul(offset, length, flags=["nsw"])
        if level < len(indices):
            step = context.cast(builder, indices[level], kinds[level], types.int64)
            offset = step if offset is None else builder.add(offset, step, flags=["nsw"])
    return builder.gep(data, [offset], inbounds=True), lengths[len(indices) :]


def _view(context: Context, builder: IRBuilder, kind: View, data: Value, lengths: Values) -> Value:
    value = ir.Constant(context.get_value_type(kind), ir.Undefined)
    for place, part in enumerate((data, *lengths)):
        value = builder.insert_value(value, part, place)
    return value


def _tag(builder: IRBuilder, access: Instruction, what: object) -> Instruction:
    """Floats, integers and each scalar of a frame never share memory."""
    module = builder.module
    kind = module.add_metadata([str(what), module.add_metadata(["fiv"])])
    access.set_metadata("tbaa", module.add_metadata([kind, kind, ir.Constant(INTEGER, 0)]))
    return access


@lower_builtin(operator.getitem, View, types.Integer)
@lower_builtin(operator.getitem, View, types.BaseTuple)
def _item(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
    place, lengths = _place(context, builder, signature, given)
    if lengths:
        return _view(context, builder, signature.return_type, place, lengths)
    return _tag(builder, builder.load(place), signature.return_type)


@lower_builtin(operator.getitem, View, types.SliceType)
def _rest(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
    view, index = given
    start = context.make_helper(builder, signature.args[1], index).start
    data = builder.gep(builder.extract_value(view, 0), [start], inbounds=True)
    length = builder.sub(builder.extract_value(view, 1), start)
    return _view(context, builder, signature.return_type, data, [length])


@lower_builtin(operator.setitem, View, types.Integer, types.Number)
@lower_builtin(operator.setitem, View, types.BaseTuple, types.Number)
def _set_item(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
    place, _ = _place(context, builder, signature, given)
    element = signature.args[0].element
    value = context.cast(builder, given[2], signature.args[2], element)
    _tag(builder, builder.store(value, place), element)
    return context.get_dummy_value()


# --- lengths --------------------------------------------------------------------------------------
@intrinsic
def _lengths(context: Context, view: types.Type) -> tuple[Signature, Kernel]:
    def lower(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
        lengths = [builder.extract_value(given[0], 1 + level) for level in range(view.depth)]
        return context.make_tuple(builder, signature.return_type, lengths)

    return types.UniTuple(types.int64, view.depth)(view), lower


@overload_attribute(View, "shape", jit_options=OPTIONS, strict=False)
def _shape(view: types.Type) -> Kernel | None:
    return lambda view: _lengths(view)


@overload(len, jit_options=OPTIONS, strict=False)
def _len(view: types.Type) -> Kernel | None:
    return (lambda view: _lengths(view)[0]) if isinstance(view, View) else None


# --- frames ---------------------------------------------------------------------------------------
def _word(builder: IRBuilder, words: Value, place: int) -> Value:
    """A word of a frame: it does not change while kernels run."""
    loaded = builder.load(builder.gep(words, [ir.Constant(INTEGER, place)]))
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


@lower_getattr_generic(FrameType)
def _read_field(
    context: Context, builder: IRBuilder, kind: FrameType, frame: Value, name: str
) -> Value:
    field = kind.frame.fields[name]
    return (_array if field.kind.depth else _scalar)(context, builder, frame, field)


def _array(context: Context, builder: IRBuilder, frame: Value, field: Field) -> Value:
    view = _type_of_field(field.kind)
    words = builder.bitcast(frame, INTEGER.as_pointer())
    data, *lengths = (_word(builder, words, field.place + i) for i in range(field.kind.words))
    if field.kind.is_own:
        data = builder.add(data, builder.ptrtoint(frame, INTEGER))
    pointer = context.get_value_type(types.CPointer(view.element))
    return _view(context, builder, view, builder.inttoptr(data, pointer), lengths)


def _scalar(context: Context, builder: IRBuilder, frame: Value, field: Field) -> Value:
    loaded = builder.load(_place_of_scalar(builder, frame, field))
    if field.kind.is_fixed:
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return _tag(builder, loaded, field.name)


@lower_setattr_generic(FrameType)
def _write_scalar(
    context: Context, builder: IRBuilder, signature: Signature, given: Values, name: str
) -> None:
    field = signature.args[0].frame.fields[name]
    if field.kind.depth or field.kind.is_fixed:
        raise TypeError(f"kernels do not write {name}")
    frame, value = given
    _tag(builder, builder.store(value, _place_of_scalar(builder, frame, field)), name)


def _place_of_scalar(builder: IRBuilder, frame: Value, field: Field) -> Value:
    words = builder.bitcast(
        frame, (DOUBLE if field.kind.element is float else INTEGER).as_pointer()
    )
    return builder.gep(words, [ir.Constant(INTEGER, field.place)])


@cache
def register_frame(frame: type[Frame], frame_at: Callable[[int], object]) -> None:
    """Let kernels take a frame from its address, by `frame_at`."""
    kind = FrameType(frame)
    type_callable(frame_at)(lambda context: lambda address: kind)
    lower_builtin(frame_at, types.Integer)(_frame_at)


def _frame_at(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
    return builder.inttoptr(given[0], context.get_value_type(signature.return_type))


# --- arrays at an address -------------------------------------------------------------------------
@type_callable(floats_at)
def _type_of_floats(context: Context) -> Callable[..., types.Type | None]:
    return lambda address, rows, columns: View(types.float64, 2)


@lower_builtin(floats_at, types.Integer, types.Integer, types.Integer)
def _floats_at(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
    address, *lengths = given
    data = builder.inttoptr(address, DOUBLE.as_pointer())
    return _view(context, builder, signature.return_type, data, lengths)


# --- generated code, bits -------------------------------------------------------------------------
@type_callable(call_generated)
def _type_of_call(context: Context) -> Callable[..., types.Type | None]:
    return lambda address, coefficients, time, state, out: types.none


@lower_builtin(call_generated, types.Integer, View, types.Float, View, View)
def _call_generated(
    context: Context, builder: IRBuilder, signature: Signature, given: Values
) -> Value:
    address, coefficients, time, state, out = given
    c, y, found = (builder.extract_value(view, 0) for view in (coefficients, state, out))
    function = builder.inttoptr(address, GENERATED.as_pointer())
    builder.call(function, [c, time, y, found], attrs=("nounwind",))
    return context.get_dummy_value()


@type_callable(call_driver)
def _type_of_driving(context: Context) -> Callable[..., types.Type | None]:
    return lambda address, frame, until, interval, measuring: types.int64


@lower_builtin(call_driver, types.Integer, types.Integer, types.Float, types.Float, types.Boolean)
def _call_driver(
    context: Context, builder: IRBuilder, signature: Signature, given: Values
) -> Value:
    address, *arguments, measuring = given
    function = builder.inttoptr(address, DRIVER.as_pointer())
    flag = builder.zext(measuring, ir.IntType(8))
    return builder.call(function, [*arguments, flag], attrs=("nounwind",))


@type_callable(bits_of)
def _type_of_bits(context: Context) -> Callable[..., types.Type | None]:
    return lambda value: types.int64


@type_callable(float_of)
def _type_of_float(context: Context) -> Callable[..., types.Type | None]:
    return lambda bits: types.float64


@lower_builtin(bits_of, types.Float)
@lower_builtin(float_of, types.Integer)
def _bitcast(context: Context, builder: IRBuilder, signature: Signature, given: Values) -> Value:
    return builder.bitcast(given[0], context.get_value_type(signature.return_type))
