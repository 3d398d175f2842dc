"""Hand-written kernels to machine code: the part of Python that they need, no more.

A kernel is a function marked `native`, with annotated parameters. Its text is read with `ast` and
written as LLVM IR, the functions that it calls likewise. There is nothing to infer: a variable has
the type of what it is first set to, arrays come as parameters or as fields of a `Frame`. So a
driver of a thousand lines takes two seconds where a general front end takes twenty, and a call
from Python hands over one address instead of an array at a time.

What a kernel may use: int, float and bool; arrays by index (never counted from the end, never out
of bounds: nothing checks), their rows, what follows an index,
``len`` and ``shape``; assignment, ``if``, ``while``,
``for`` over ``range``, ``break``, ``continue``, ``return``; arithmetic, comparison, ``and``,
``or``, ``not``, conditional expressions; abs, min, max, int, float, np.floor, np.sqrt; constants
of its module; other kernels. Integers divide as C's do: the sign of both sides must be the same.
There is no fast-math and no contraction to fused multiply-add. The same text runs under Python.
"""

from __future__ import annotations

import ast
import ctypes
import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numpy.typing import NDArray

from fiv_cli.codegen import cache as store
from fiv_cli.codegen.lower import load_object, machine_description, target_machine

Floats = NDArray[np.float64]
OwnFloats = NDArray[np.float64]
Floats2 = NDArray[np.float64]
Ints = NDArray[np.int64]
OwnInts = NDArray[np.int64]
Ints2 = NDArray[np.int64]
Ints3 = NDArray[np.int64]

DOUBLE, INTEGER, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
SCALARS = {"float": DOUBLE, "int": INTEGER, "bool": TRUTH}
ARRAYS = {
    "Floats": (DOUBLE, 1),
    "Floats2": (DOUBLE, 2),
    "OwnFloats": (DOUBLE, 1),
    "Ints": (INTEGER, 1),
    "Ints2": (INTEGER, 2),
    "Ints3": (INTEGER, 3),
    "OwnInts": (INTEGER, 1),
}
NOTHING = ctypes.c_char * 0
GENERATED = ir.FunctionType(
    ir.VoidType(), (DOUBLE.as_pointer(), DOUBLE, DOUBLE.as_pointer(), DOUBLE.as_pointer())
)
C_TYPES: dict[str, Any] = {"float": ctypes.c_double, "int": ctypes.c_int64, "bool": ctypes.c_bool}


def native(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a kernel; under Python it stays what it is."""
    function.__native__ = True  # type: ignore[attr-defined]
    return function


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a kernel that is to be compiled into its callers."""
    function.__inlined__ = True  # type: ignore[attr-defined]
    return native(function)


def bits_of(value: float) -> int:
    """The 64 bits of a float, as an integer."""
    return int(np.float64(value).view(np.int64))


def float_of(bits: int) -> float:
    """The float of 64 bits."""
    return float(np.int64(bits).view(np.float64))


def call_generated(
    address: int, coefficients: Floats, time: float, state: Floats, out: Floats
) -> None:
    """Call the generated function at `address` with the data of the arrays."""
    GENERATED_FROM_PYTHON(address)(
        coefficients.ctypes.data, time, state.ctypes.data, out.ctypes.data
    )


@cache
def GENERATED_FROM_PYTHON(address: int) -> Any:
    pointer = ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, pointer, ctypes.c_double, pointer, pointer)(int(address))


class Frame:
    """Base of the record of arrays that kernels share: annotated fields, nothing else.

    In memory each field is its address and its lengths, as 64-bit words; of an array of the
    frame's own (`OwnFloats`, `OwnInts`) the address counts from that of the frame, so that a frame
    is copied together with arrays that follow it in the same block.
    """

    @classmethod
    @cache
    def places(cls) -> Mapping[str, int]:
        """Field -> its first word."""
        places, place = {}, 0
        for name, annotation in cls.__annotations__.items():
            places[name] = place
            place += 1 + ARRAYS[annotation][1]
        return places

    @classmethod
    def words(cls, arrays: Mapping[str, NDArray[Any]]) -> Ints:
        """The words of these arrays, zeros for the rest; keep the arrays alive meanwhile."""
        places = cls.places()
        words = np.zeros(sum(1 + ARRAYS[kind][1] for kind in cls.__annotations__.values()), int)
        for name, array in arrays.items():
            element, depth = ARRAYS[cls.__annotations__[name]]
            expected = np.float64 if element is DOUBLE else np.int64
            assert array.dtype == expected and array.ndim == depth and array.flags.c_contiguous, (
                name
            )
            words[places[name] : places[name] + 1 + depth] = words_of(array)
        return words


def words_of(array: NDArray[Any]) -> tuple[int, ...]:
    """Address and lengths of an array, as frames and compiled kernels take them."""
    return (address_of(array), *array.shape)


def address_of(array: NDArray[Any]) -> int:
    """Where the data of a contiguous array begin (numpy's own ways take four times as long)."""
    return ctypes.addressof(NOTHING.from_buffer(array))  # type: ignore[arg-type]


# --- compiling, loading ---------------------------------------------------------------------------
class Library:
    """Kernels that are compiled together, once per user, on first use.

    Parameters
    ----------
    name : of the file in the cache
    files : source files that decide the code; their content is the key
    entries : the kernels that Python calls; scalars and one frame as parameters
    """

    def __init__(self, name: str, files: tuple[Path, ...], entries: tuple[Any, ...]):
        self.name, self.files, self.entries = name, files, entries
        self._functions: dict[str, Any] = {}
        self._engine: Any = None

    def key(self) -> str:
        """Hash of the sources, the compiler and the processor."""
        own = (Path(__file__), Path(__file__).with_name("lower.py"))
        return store.content_key([store.source_of(*self.files, *own), machine_description()])

    def is_warm(self) -> bool:
        """Whether this user's cache holds the object code."""
        return store.read(self._file()) is not None

    def function(self, entry: Any) -> Any:
        """The compiled kernel, to be called with addresses of frames or data, and scalars."""
        if entry.__name__ not in self._functions:
            address = self._loaded().get_function_address(entry.__name__)
            self._functions[entry.__name__] = _prototype(entry)(address)
        return self._functions[entry.__name__]

    def _file(self) -> str:
        return f"{self.name}-{self.key()}.o"

    def _loaded(self) -> Any:
        if self._engine is None:
            code = store.read(self._file())
            if code is None:
                code = compile_kernels(self.entries)
                store.write(self._file(), code)
            self._engine = load_object(code)
        return self._engine


def _prototype(entry: Any) -> Any:
    definition = _definition(entry)
    result = definition.returns.id if isinstance(definition.returns, ast.Name) else None
    kinds: list[Any] = []
    for argument in definition.args.args:
        name = _name(argument.annotation)
        depth = ARRAYS[name][1] if name in ARRAYS else 0
        kinds += [C_TYPES.get(name, ctypes.c_void_p), *[ctypes.c_int64] * depth]
    return ctypes.CFUNCTYPE(C_TYPES[result] if result else None, *kinds)


def compile_kernels(entries: tuple[Any, ...]) -> bytes:
    """Object code of these kernels and all that they call."""
    translation = _Translation()
    for entry in entries:
        translation.function(entry).linkage = "external"
    machine = target_machine()
    module = llvm.parse_assembly(str(translation.module))
    module.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = options.slp_vectorization = False  # loops of a dozen terms
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


@cache
def _definition(function: Any) -> ast.FunctionDef:
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    definition = tree.body[0]
    assert isinstance(definition, ast.FunctionDef)
    return definition


# --- translation ----------------------------------------------------------------------------------
@dataclass(frozen=True)
class Array:
    """An array in the code: where its data begin, its lengths."""

    element: Any
    data: Any
    shape: tuple[Any, ...]


@dataclass(frozen=True)
class FramePointer:
    """A frame in the code."""

    kind: type[Frame]
    words: Any


@dataclass(frozen=True)
class Local:
    """A variable in the code."""

    kind: Any
    place: Any


class _Translation:
    """One module: kernels on demand, constants, what is called outside."""

    def __init__(self) -> None:
        self.module = ir.Module(name="kernels")
        self.functions: dict[Any, ir.Function] = {}
        self.constants: dict[int, Array] = {}
        self.pow = ir.Function(self.module, ir.FunctionType(DOUBLE, (DOUBLE, DOUBLE)), "pow")
        self.pow.attributes.add("readnone")
        self.pow.attributes.add("nounwind")
        self.fabs = self.module.declare_intrinsic("llvm.fabs", [DOUBLE])
        self.sqrt = self.module.declare_intrinsic("llvm.sqrt", [DOUBLE])
        self.floor = self.module.declare_intrinsic("llvm.floor", [DOUBLE])
        self.invariant = self.module.add_metadata([])
        root = self.module.add_metadata(["fiv"])
        self.access = {element: self._access_tag(name, root)
                       for name, element in (("float", DOUBLE), ("int", INTEGER))}  # fmt: skip

    def _access_tag(self, name: str, root: Any) -> Any:
        kind = self.module.add_metadata([name, root])
        return self.module.add_metadata([kind, kind, ir.Constant(INTEGER, 0)])

    def function(self, kernel: Any) -> ir.Function:
        """The kernel, translated on first use."""
        if kernel not in self.functions:
            definition = _definition(kernel)
            function = ir.Function(
                self.module, _signature(definition, kernel.__globals__), kernel.__name__
            )
            function.linkage = "internal"
            function.attributes.add("nounwind")
            if hasattr(kernel, "__inlined__"):
                function.attributes.add("alwaysinline")
            self.functions[kernel] = function
            _Body(self, function, definition, kernel.__globals__).run()
        return self.functions[kernel]

    def constant(self, array: NDArray[np.float64]) -> Array:
        """A table of the module that a kernel stands in."""
        if id(array) not in self.constants:
            kind = ir.ArrayType(DOUBLE, len(array))
            table = ir.GlobalVariable(self.module, kind, f"table{len(self.constants)}")
            table.global_constant, table.linkage = True, "internal"
            table.initializer = ir.Constant(kind, [float(value) for value in array])
            zero = ir.Constant(INTEGER, 0)
            data = table.gep([zero, zero])
            self.constants[id(array)] = Array(DOUBLE, data, (ir.Constant(INTEGER, len(array)),))
        return self.constants[id(array)]


def _signature(definition: ast.FunctionDef, known: Mapping[str, Any]) -> ir.FunctionType:
    kinds: list[Any] = []
    for argument in definition.args.args:
        kinds += _parameter_kinds(_name(argument.annotation), known)
    return ir.FunctionType(_result(definition.returns), kinds)


def _parameter_kinds(annotation: str, known: Mapping[str, Any]) -> list[Any]:
    if annotation in SCALARS:
        return [SCALARS[annotation]]
    if annotation in ARRAYS:
        element, depth = ARRAYS[annotation]
        return [element.as_pointer(), *[INTEGER] * depth]
    assert issubclass(known[annotation], Frame)
    return [INTEGER.as_pointer()]


def _result(annotation: ast.expr | None) -> Any:
    if isinstance(annotation, ast.Constant):  # None
        return ir.VoidType()
    if isinstance(annotation, ast.Subscript):  # tuple[...]
        assert isinstance(annotation.slice, ast.Tuple)
        return ir.LiteralStructType([SCALARS[_name(kind)] for kind in annotation.slice.elts])
    return SCALARS[_name(annotation)]


def _name(node: ast.expr | None) -> str:
    assert isinstance(node, ast.Name)
    return node.id


class _Body:
    """The body of one kernel."""

    def __init__(
        self,
        translation: _Translation,
        function: ir.Function,
        definition: ast.FunctionDef,
        known: Mapping[str, Any],
    ) -> None:
        self.translation, self.function, self.definition = translation, function, definition
        self.known = known
        self.names: dict[str, Local | Array | FramePointer] = {}
        self.entry = ir.IRBuilder(function.append_basic_block("entry"))
        self.first = function.append_basic_block("body")
        self.build = ir.IRBuilder(self.first)
        self.loops: list[tuple[Any, Any]] = []  # where `continue` and `break` go

    def run(self) -> None:
        """Translate everything."""
        values = list(self.function.args)
        for argument in self.definition.args.args:
            self._take(argument.arg, _name(argument.annotation), values)
        self._block(self.definition.body)
        if not self.build.block.is_terminated:
            if isinstance(self.function.ftype.return_type, ir.VoidType):
                self.build.ret_void()
            else:
                self.build.unreachable()
        self.entry.branch(self.first)

    def _take(self, name: str, annotation: str, values: list[Any]) -> None:
        if annotation in SCALARS:
            self._set(name, values.pop(0))
        elif annotation in ARRAYS:
            element, depth = ARRAYS[annotation]
            data, shape = values.pop(0), tuple(values.pop(0) for _ in range(depth))
            self.names[name] = Array(element, data, shape)
        else:
            self.names[name] = FramePointer(self.known[annotation], values.pop(0))

    # --- statements -------------------------------------------------------------------------------
    def _block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            try:
                getattr(self, f"_{type(statement).__name__}")(statement)
            except (AttributeError, AssertionError, KeyError) as error:
                place = f"{self.definition.name}, line {statement.lineno}"
                raise NotImplementedError(f"{place}: {ast.unparse(statement)}") from error
            if self.build.block.is_terminated:
                return

    def _Expr(self, statement: ast.Expr) -> None:
        if not isinstance(statement.value, ast.Constant):  # a docstring says it to people
            self._value(statement.value)

    def _Assign(self, statement: ast.Assign) -> None:
        (target,) = statement.targets
        if not isinstance(target, ast.Tuple):
            self._assign(target, self._value(statement.value))
        elif isinstance(statement.value, ast.Tuple):
            values = [self._value(value) for value in statement.value.elts]
            for place, value in zip(target.elts, values, strict=True):
                self._assign(place, value)
        else:
            together = self._value(statement.value)
            for number, place in enumerate(target.elts):
                self._assign(place, self.build.extract_value(together, number))

    def _assign(self, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Subscript):
            array, place = self._place(target)
            store = self.build.store(self._as(value, array.element), place)
            store.set_metadata("tbaa", self.translation.access[array.element])
        elif isinstance(value, Array):
            self.names[_name(target)] = value
        else:
            self._set(_name(target), value)

    def _set(self, name: str, value: Any) -> None:
        if name not in self.names:
            self.names[name] = Local(value.type, self.entry.alloca(value.type))
        local = self.names[name]
        assert isinstance(local, Local)
        self.build.store(self._as(value, local.kind), local.place)

    def _AugAssign(self, statement: ast.AugAssign) -> None:
        old, change = self._value(statement.target), self._value(statement.value)
        self._assign(statement.target, self._operation(statement.op, old, change))

    def _Return(self, statement: ast.Return) -> None:
        kind = self.function.ftype.return_type
        if statement.value is None:
            self.build.ret_void()
        elif isinstance(statement.value, ast.Tuple):
            together = ir.Constant(kind, ir.Undefined)
            for number, node in enumerate(statement.value.elts):
                value = self._as(self._value(node), kind.elements[number])
                together = self.build.insert_value(together, value, number)
            self.build.ret(together)
        else:
            self.build.ret(self._as(self._value(statement.value), kind))

    def _If(self, statement: ast.If) -> None:
        then, after = self._new_block("then"), self._new_block("after")
        otherwise = self._new_block("else") if statement.orelse else after
        self.build.cbranch(self._truth(statement.test), then, otherwise)
        for block, body in ((then, statement.body), (otherwise, statement.orelse)):
            if block is not after:
                self._block_to(block, body, after)
        self.build.position_at_end(after)

    def _block_to(self, block: Any, statements: list[ast.stmt], following: Any) -> None:
        self.build.position_at_end(block)
        self._block(statements)
        if not self.build.block.is_terminated:
            self.build.branch(following)

    def _While(self, statement: ast.While) -> None:
        again, body = self._new_block("while"), self._new_block("body")
        after = self._new_block("after")
        self.build.branch(again)
        self.build.position_at_end(again)
        self.build.cbranch(self._truth(statement.test), body, after)
        self.loops.append((again, after))
        self._block_to(body, statement.body, again)
        self.loops.pop()
        self.build.position_at_end(after)

    def _For(self, statement: ast.For) -> None:
        assert isinstance(statement.iter, ast.Call)
        assert _name(statement.iter.func) == "range"
        first, end, step = self._range(statement.iter.args)
        counter = self.entry.alloca(INTEGER)
        self.build.store(first, counter)
        again, body = self._new_block("for"), self._new_block("body")
        following, after = self._new_block("next"), self._new_block("after")
        self.build.branch(again)
        self.build.position_at_end(again)
        number = self.build.load(counter)
        goes_on = self.build.icmp_signed("<" if step > 0 else ">", number, end)
        self.build.cbranch(goes_on, body, after)
        self.build.position_at_end(body)
        self._assign(statement.target, number)
        self.loops.append((following, after))
        self._block_to(body, statement.body, following)
        self.loops.pop()
        self.build.position_at_end(following)
        ahead = self.build.add(self.build.load(counter), ir.Constant(INTEGER, step), flags=["nsw"])
        self.build.store(ahead, counter)
        self.build.branch(again)
        self.build.position_at_end(after)

    def _range(self, bounds: list[ast.expr]) -> tuple[Any, Any, int]:
        step = int(ast.literal_eval(bounds[2])) if len(bounds) == 3 else 1
        values = [self._value(bound) for bound in bounds[:2]]
        return (ir.Constant(INTEGER, 0), values[0], 1) if len(bounds) == 1 else (*values, step)

    def _Break(self, statement: ast.Break) -> None:
        self.build.branch(self.loops[-1][1])

    def _Continue(self, statement: ast.Continue) -> None:
        self.build.branch(self.loops[-1][0])

    def _new_block(self, name: str) -> Any:
        return self.function.append_basic_block(name)

    # --- expressions ------------------------------------------------------------------------------
    def _value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=value):
                return _constant(value)
            case ast.Name(id=name):
                return self._named(name)
            case ast.Attribute():
                return self._attribute(node)
            case ast.Subscript():
                return self._element(node)
            case ast.UnaryOp(op=op, operand=operand):
                return self._unary(op, operand)
            case ast.BinOp(left=left, op=op, right=right):
                return self._operation(op, self._value(left), self._value(right))
            case ast.Compare():
                return self._comparison(node)
            case ast.BoolOp(op=op, values=values):
                return self._chain(op, values)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self._choice(test, body, orelse)
            case ast.Call():
                return self._call(node)
        raise NotImplementedError(ast.dump(node))

    def _named(self, name: str) -> Any:
        if name not in self.names:
            known = self.known[name]
            if isinstance(known, np.ndarray):
                return self.translation.constant(known)
            return _constant(known)
        found = self.names[name]
        return self.build.load(found.place) if isinstance(found, Local) else found

    def _attribute(self, node: ast.Attribute) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id not in self.names:
            return _constant(getattr(self.known[node.value.id], node.attr))  # np.inf, np.pi
        owner = self._value(node.value)
        assert isinstance(owner, FramePointer)
        return self._field(owner, node.attr)

    def _field(self, frame: FramePointer, name: str) -> Array:
        element, depth = ARRAYS[frame.kind.__annotations__[name]]
        place = frame.kind.places()[name]
        data, *shape = (self._word(frame.words, place + i) for i in range(1 + depth))
        if frame.kind.__annotations__[name].startswith("Own"):
            data = self.build.add(data, self.build.ptrtoint(frame.words, INTEGER))
        return Array(element, self.build.inttoptr(data, element.as_pointer()), tuple(shape))

    def _word(self, words: Any, place: int) -> Any:
        """A word of a frame: it does not change while kernels run."""
        loaded = self.build.load(self.build.gep(words, [ir.Constant(INTEGER, place)]))
        loaded.set_metadata("invariant.load", self.translation.invariant)
        return loaded

    def _element(self, node: ast.Subscript) -> Any:
        if isinstance(node.slice, ast.Slice):
            return self._rest(node)
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            array = self._value(node.value.value)
            return array.shape[ast.literal_eval(node.slice)]
        array, place = self._place(node)
        if isinstance(array, Array) and array.shape:
            return array
        loaded = self.build.load(place)
        loaded.set_metadata("tbaa", self.translation.access[array.element])
        return loaded

    def _rest(self, node: ast.Subscript) -> Array:
        """A flat array from an index on."""
        array, bounds = self._value(node.value), node.slice
        assert isinstance(bounds, ast.Slice)
        assert bounds.upper is None
        assert len(array.shape) == 1
        first = self._value(bounds.lower)
        data = self.build.gep(array.data, [first], inbounds=True)
        return Array(array.element, data, (self.build.sub(array.shape[0], first),))

    def _place(self, node: ast.Subscript) -> tuple[Array, Any]:
        """A row (an array that has a shape left) or the place of an element."""
        array = self._value(node.value)
        assert isinstance(array, Array)
        index = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        offset = self._value(index[0])
        for level in range(1, len(array.shape)):
            offset = self.build.mul(offset, array.shape[level], flags=["nsw"])
            if level < len(index):
                offset = self.build.add(offset, self._value(index[level]), flags=["nsw"])
        place = self.build.gep(array.data, [offset], inbounds=True)
        return Array(array.element, place, array.shape[len(index) :]), place

    def _unary(self, op: ast.unaryop, operand: ast.expr) -> Any:
        if isinstance(op, ast.Not):
            return self.build.not_(self._truth(operand))
        assert isinstance(op, ast.USub)
        value = self._value(operand)
        return self.build.fneg(value) if value.type == DOUBLE else self.build.neg(value)

    def _operation(self, op: ast.operator, left: Any, right: Any) -> Any:
        if isinstance(op, ast.Pow):
            return self._power(left, right)
        if left.type == right.type == INTEGER and not isinstance(op, ast.Div):
            build = {ast.Add: self.build.add, ast.Sub: self.build.sub, ast.Mult: self.build.mul,
                     ast.FloorDiv: self.build.sdiv, ast.Mod: self.build.srem}[type(op)]  # fmt: skip
        else:
            left, right = self._as(left, DOUBLE), self._as(right, DOUBLE)
            build = {ast.Add: self.build.fadd, ast.Sub: self.build.fsub,
                     ast.Mult: self.build.fmul, ast.Div: self.build.fdiv}[type(op)]  # fmt: skip
        return build(left, right)

    def _power(self, base: Any, exponent: Any) -> Any:
        if isinstance(exponent, ir.Constant) and exponent.constant == 2:
            return self.build.fmul(base, base)
        assert exponent.type == DOUBLE
        return self.build.call(self.translation.pow, [base, exponent])

    def _comparison(self, node: ast.Compare) -> Any:
        values = [self._value(value) for value in (node.left, *node.comparators)]
        found = [
            self._compare(op, left, right)
            for op, left, right in zip(node.ops, values, values[1:], strict=False)
        ]
        result = found[0]
        for further in found[1:]:
            result = self.build.and_(result, further)
        return result

    def _compare(self, op: ast.cmpop, left: Any, right: Any) -> Any:
        symbol = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==",
                  ast.NotEq: "!="}[type(op)]  # fmt: skip
        if DOUBLE not in (left.type, right.type):
            return self.build.icmp_signed(symbol, left, right)
        compare = self.build.fcmp_unordered if symbol == "!=" else self.build.fcmp_ordered
        return compare(symbol, self._as(left, DOUBLE), self._as(right, DOUBLE))

    def _chain(self, op: ast.boolop, values: list[ast.expr]) -> Any:
        """``and``, ``or``: what decides ends it."""
        after, deciding = self._new_block("decided"), isinstance(op, ast.Or)
        ends = []
        for value in values[:-1]:
            truth, further = self._truth(value), self._new_block("further")
            ends.append(self.build.block)
            self.build.cbranch(truth, *((after, further) if deciding else (further, after)))
            self.build.position_at_end(further)
        last = self._truth(values[-1])
        ends.append(self.build.block)
        self.build.branch(after)
        self.build.position_at_end(after)
        result = self.build.phi(TRUTH)
        for block in ends[:-1]:
            result.add_incoming(ir.Constant(TRUTH, int(deciding)), block)
        result.add_incoming(last, ends[-1])
        return result

    def _choice(self, test: ast.expr, body: ast.expr, orelse: ast.expr) -> Any:
        then, otherwise = self._new_block("then"), self._new_block("else")
        after = self._new_block("chosen")
        self.build.cbranch(self._truth(test), then, otherwise)
        found = []
        for block, node in ((then, body), (otherwise, orelse)):
            self.build.position_at_end(block)
            found.append((self._value(node), self.build.block))
        kind = DOUBLE if DOUBLE in (found[0][0].type, found[1][0].type) else found[0][0].type
        result_parts = []
        for value, block in found:
            self.build.position_at_end(block)
            result_parts.append((self._as(value, kind), block))
            self.build.branch(after)
        self.build.position_at_end(after)
        result = self.build.phi(kind)
        for value, block in result_parts:
            result.add_incoming(value, block)
        return result

    def _truth(self, node: ast.expr) -> Any:
        value = self._value(node)
        assert value.type == TRUTH
        return value

    def _as(self, value: Any, kind: Any) -> Any:
        """`value` as `kind`; an integer may become a float, nothing else changes by itself."""
        if value.type == INTEGER and kind == DOUBLE:
            return self.build.sitofp(value, DOUBLE)
        assert value.type == kind
        return value

    # --- calls ------------------------------------------------------------------------------------
    def _call(self, node: ast.Call) -> Any:
        if isinstance(node.func, ast.Attribute):
            function = {"floor": self.translation.floor, "sqrt": self.translation.sqrt}
            return self.build.call(function[node.func.attr], [self._value(node.args[0])])
        name = _name(node.func)
        values = [self._value(argument) for argument in node.args]
        if name not in self.known:
            return getattr(self, f"_call_{name}")(*values)
        if self.known[name] is call_generated:
            return self._call_generated(*values)
        if self.known[name] in (bits_of, float_of):
            return self.build.bitcast(*values, INTEGER if self.known[name] is bits_of else DOUBLE)
        callee = self.translation.function(self.known[name])
        given: list[Any] = []
        for value in values:
            given += _flat(value)
        kinds = callee.ftype.args
        return self.build.call(
            callee, [self._as(value, kind) for value, kind in zip(given, kinds, strict=True)]
        )

    def _call_generated(self, address: Any, c: Array, t: Any, y: Array, out: Array) -> Any:
        function = self.build.inttoptr(address, GENERATED.as_pointer())
        return self.build.call(function, [c.data, t, y.data, out.data], attrs=("nounwind",))

    def _call_abs(self, value: Any) -> Any:
        return self.build.call(self.translation.fabs, [value])

    def _call_min(self, first: Any, second: Any) -> Any:
        return self._extreme("<", first, second)

    def _call_max(self, first: Any, second: Any) -> Any:
        return self._extreme(">", first, second)

    def _extreme(self, symbol: str, first: Any, second: Any) -> Any:
        """As Python has it: the second only if it is beyond the first."""
        if first.type == second.type == INTEGER:
            return self.build.select(self.build.icmp_signed(symbol, second, first), second, first)
        first, second = self._as(first, DOUBLE), self._as(second, DOUBLE)
        return self.build.select(self.build.fcmp_ordered(symbol, second, first), second, first)

    def _call_int(self, value: Any) -> Any:
        return self.build.fptosi(value, INTEGER) if value.type == DOUBLE else value

    def _call_float(self, value: Any) -> Any:
        return self._as(value, DOUBLE)

    def _call_len(self, array: Array) -> Any:
        return array.shape[0]


def _flat(value: Any) -> list[Any]:
    if isinstance(value, Array):
        return [value.data, *value.shape]
    return [value.words] if isinstance(value, FramePointer) else [value]


def _constant(value: Any) -> ir.Constant:
    if isinstance(value, bool):
        return ir.Constant(TRUTH, int(value))
    if isinstance(value, int):
        return ir.Constant(INTEGER, value)
    assert isinstance(value, float)
    return ir.Constant(DOUBLE, value)
