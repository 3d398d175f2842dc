"""Kernels to LLVM assembly: the part of Python that `native.py` promises.

A kernel's text is read with `ast`; what it calls is translated with it. There is nothing to infer:
a variable has the type of what it is first set to.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numpy.typing import NDArray

from fiv_cli.codegen.lower import target_machine
from fiv_cli.codegen.native import (
    ARRAYS,
    Frame,
    KernelError,
    bits_of,
    call_generated,
    float_of,
    symbol,
)

DOUBLE, INTEGER, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
SCALARS = {"float": DOUBLE, "int": INTEGER, "bool": TRUTH}
ELEMENTS = {float: DOUBLE, int: INTEGER}
ARRAY_KINDS = {name: (ELEMENTS[element], depth) for name, (element, depth) in ARRAYS.items()}
GENERATED = ir.FunctionType(
    ir.VoidType(), (DOUBLE.as_pointer(), DOUBLE, DOUBLE.as_pointer(), DOUBLE.as_pointer())
)
BUILTINS = ("abs", "min", "max", "int", "float", "len")


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
def _definition(kernel: Any) -> ast.FunctionDef:
    """The text of a kernel, with line numbers of its file."""
    try:
        lines, first = inspect.getsourcelines(kernel)
    except (OSError, TypeError) as error:
        raise KernelError(f"{symbol(kernel)}: its source cannot be read") from error
    definition = ast.parse(textwrap.dedent("".join(lines))).body[0]
    assert isinstance(definition, ast.FunctionDef)
    ast.increment_lineno(definition, first - 1)
    return definition


def _refusal(kernel: Any, node: ast.stmt, error: Exception) -> KernelError:
    """What to say of a statement that cannot be lowered."""
    place = f"{Path(inspect.getfile(kernel)).name}, {kernel.__name__}, line {node.lineno}"
    text = ast.unparse(node).splitlines()[0]
    return KernelError(f"{place}: {text}" + f" ({error})" * bool(str(error)))


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
    """A variable in the code: its kind (of an array: element and depth), where its parts are."""

    kind: Any
    places: tuple[Any, ...]


class _Translation:
    """One module: kernels on demand, constants, what is called outside."""

    def __init__(self) -> None:
        self.module = ir.Module(name="kernels")
        self.functions: dict[Any, ir.Function] = {}
        self.constants: dict[int, Array] = {}
        self.pow = ir.Function(self.module, ir.FunctionType(DOUBLE, (DOUBLE, DOUBLE)), "pow")
        for attribute in ("readnone", "nounwind", "nobuiltin"):  # x ** 0.5 is not a square root
            self.pow.attributes.add(attribute)
        self.fabs = self.module.declare_intrinsic("llvm.fabs", [DOUBLE])
        self.numpy = {np.floor: self.module.declare_intrinsic("llvm.floor", [DOUBLE]),
                      np.sqrt: self.module.declare_intrinsic("llvm.sqrt", [DOUBLE])}  # fmt: skip
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
            try:
                signature = _signature(kernel)
                function = ir.Function(self.module, signature, symbol(kernel))
            except Exception as error:
                raise _refusal(kernel, definition, error) from error
            function.linkage = "internal"
            function.attributes.add("nounwind")
            if signature.return_type == TRUTH:
                function.return_value.add_attribute("zeroext")  # C reads the whole byte
            if hasattr(kernel, "__inlined__"):
                function.attributes.add("alwaysinline")
            self.functions[kernel] = function
            _Body(self, function, kernel).run()
        return self.functions[kernel]

    def constant(self, array: NDArray[Any]) -> Array:
        """A table of the module that a kernel stands in."""
        if id(array) not in self.constants:
            element = {np.dtype(np.float64): DOUBLE, np.dtype(np.int64): INTEGER}[array.dtype]
            assert array.ndim == 1, "a table has one dimension"
            kind = ir.ArrayType(element, len(array))
            table = ir.GlobalVariable(self.module, kind, f"table{len(self.constants)}")
            table.global_constant, table.linkage = True, "internal"
            table.initializer = ir.Constant(kind, array.tolist())
            zero = ir.Constant(INTEGER, 0)
            data = table.gep([zero, zero])
            self.constants[id(array)] = Array(element, data, (ir.Constant(INTEGER, len(array)),))
        return self.constants[id(array)]


def _signature(kernel: Any) -> ir.FunctionType:
    kinds: list[Any] = []
    for kind in _kinds(kernel):
        if isinstance(kind, tuple):
            kinds += [kind[0].as_pointer(), *[INTEGER] * kind[1]]
        else:
            kinds.append(INTEGER.as_pointer() if isinstance(kind, type) else kind)
    return ir.FunctionType(_result(_definition(kernel).returns), kinds)


def _kinds(kernel: Any) -> list[Any]:
    """Kinds of parameters: a scalar's type, an array's element and depth, a frame's class."""
    given = _definition(kernel).args
    special = (given.posonlyargs, given.kwonlyargs, given.vararg, given.kwarg, given.defaults)
    assert not any(special), "parameters are named, in order, without defaults"
    return [_kind(_name(argument.annotation), kernel.__globals__) for argument in given.args]


def _kind(annotation: str, known: Mapping[str, Any]) -> Any:
    kind = SCALARS.get(annotation) or ARRAY_KINDS.get(annotation) or known[annotation]
    assert not isinstance(kind, type) or issubclass(kind, Frame), f"{annotation} is not lowered"
    return kind


def _result(annotation: ast.expr | None) -> Any:
    if isinstance(annotation, ast.Constant):  # None
        assert annotation.value is None
        return ir.VoidType()
    if isinstance(annotation, ast.Subscript):  # tuple[...]
        assert _name(annotation.value) == "tuple"
        assert isinstance(annotation.slice, ast.Tuple)
        return ir.LiteralStructType([SCALARS[_name(kind)] for kind in annotation.slice.elts])
    return SCALARS[_name(annotation)]


def _name(node: ast.expr | None) -> str:
    assert isinstance(node, ast.Name)
    return node.id


class _Body:
    """The body of one kernel."""

    def __init__(self, translation: _Translation, function: ir.Function, kernel: Any) -> None:
        self.translation, self.function, self.kernel = translation, function, kernel
        self.known, self.definition = kernel.__globals__, _definition(kernel)
        self.own = {argument.arg for argument in self.definition.args.args} | {
            node.id
            for node in ast.walk(self.definition)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        self.names: dict[str, Local | FramePointer] = {}
        self.entry = ir.IRBuilder(function.append_basic_block("entry"))
        self.first = function.append_basic_block("body")
        self.build = ir.IRBuilder(self.first)
        self.loops: list[tuple[Any, Any]] = []  # where `continue` and `break` go

    def run(self) -> None:
        """Translate everything."""
        values = list(self.function.args)
        for argument, kind in zip(self.definition.args.args, _kinds(self.kernel), strict=True):
            self._take(argument.arg, kind, values)
        self._block(self.definition.body)
        if not self.build.block.is_terminated:
            if isinstance(self.function.ftype.return_type, ir.VoidType):
                self.build.ret_void()
            elif self._is_reached(self.build.block):
                missing = ValueError("not every way through it returns a value")
                raise _refusal(self.kernel, self.definition, missing)
            else:
                self.build.unreachable()
        self.entry.branch(self.first)

    def _is_reached(self, block: Any) -> bool:
        """Whether a way leads from the beginning to `block`."""
        reached, open_ends = {self.first}, [self.first]
        while open_ends:
            terminator = open_ends.pop().terminator
            following = [] if terminator is None else terminator.operands
            new = {end for end in following if isinstance(end, ir.Block)} - reached
            reached |= new
            open_ends += new
        return block in reached

    def _take(self, name: str, kind: Any, values: list[Any]) -> None:
        value = values.pop(0)
        if isinstance(kind, tuple):
            shape = tuple(values.pop(0) for _ in range(kind[1]))
            self._set(name, Array(kind[0], value, shape))
        elif isinstance(kind, type):
            self.names[name] = FramePointer(kind, value)
        else:
            self._set(name, value)

    # --- statements -------------------------------------------------------------------------------
    def _block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            try:
                getattr(self, f"_{type(statement).__name__}")(statement)
            except KernelError:
                raise
            except Exception as error:
                raise _refusal(self.kernel, statement, error) from error
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
            assert len(target.elts) == len(together.type.elements)
            for number, place in enumerate(target.elts):
                self._assign(place, self.build.extract_value(together, number))

    def _assign(self, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Subscript):
            self._store(value, *self._element_place(target))
        else:
            self._set(_name(target), value)

    def _store(self, value: Any, array: Array, place: Any) -> None:
        store = self.build.store(self._as(value, array.element), place)
        store.set_metadata("tbaa", self.translation.access[array.element])

    def _element_place(self, target: ast.Subscript) -> tuple[Array, Any]:
        assert not isinstance(target.value, ast.Name) or target.value.id in self.own, "a constant"
        array, place = self._place(target)
        assert not array.shape, "a row"
        return array, place

    def _set(self, name: str, value: Any) -> None:
        """Set a variable; one that is an array gets the address and lengths of another."""
        assert not isinstance(value, FramePointer)
        assert isinstance(value, Array) or not isinstance(value.type, ir.VoidType)
        kind = (value.element, len(value.shape)) if isinstance(value, Array) else value.type
        parts = _flat(value)
        if name not in self.names:
            places = tuple(self.entry.alloca(part.type) for part in parts)
            self.names[name] = Local(kind, places)
        local = self.names[name]
        assert isinstance(local, Local)
        for part, place in zip(self._given(value, local.kind), local.places, strict=True):
            self.build.store(part, place)

    def _AugAssign(self, statement: ast.AugAssign) -> None:
        if isinstance(statement.target, ast.Subscript):
            array, place = self._element_place(statement.target)
            old = self._load(array, place)
            value = self._operation(statement.op, old, self._value(statement.value))
            self._store(value, array, place)
        else:
            assert isinstance(statement.target, ast.Name)
            old = self._named(statement.target.id)
            value = self._operation(statement.op, old, self._value(statement.value))
            self._set(statement.target.id, value)

    def _Return(self, statement: ast.Return) -> None:
        kind = self.function.ftype.return_type
        if statement.value is None:
            assert isinstance(kind, ir.VoidType)
            self.build.ret_void()
        elif isinstance(statement.value, ast.Tuple):
            together = ir.Constant(kind, ir.Undefined)
            elements = zip(statement.value.elts, kind.elements, strict=True)
            for number, (node, element) in enumerate(elements):
                value = self._as(self._value(node), element)
                together = self.build.insert_value(together, value, number)
            self.build.ret(together)
        else:
            assert not isinstance(kind, ir.VoidType)
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
        assert not statement.orelse
        again, body = self._new_block("while"), self._new_block("body")
        after = self._new_block("after")
        self.build.branch(again)
        self.build.position_at_end(again)
        if isinstance(statement.test, ast.Constant) and statement.test.value is True:
            self.build.branch(body)
        else:
            self.build.cbranch(self._truth(statement.test), body, after)
        self.loops.append((again, after))
        self._block_to(body, statement.body, again)
        self.loops.pop()
        self.build.position_at_end(after)

    def _For(self, statement: ast.For) -> None:
        assert isinstance(statement.iter, ast.Call) and not statement.orelse
        assert _name(statement.iter.func) == "range" and not statement.iter.keywords
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
        step = ast.literal_eval(bounds[2]) if len(bounds) == 3 else 1
        assert 1 <= len(bounds) <= 3 and isinstance(step, int) and step != 0
        values = [self._as(self._value(bound), INTEGER) for bound in bounds[:2]]
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
                links = self._links(node)
                return self._chain(False, links, len(node.ops)) if node.ops[1:] else next(links)
            case ast.BoolOp(op=op, values=values):
                truths = (self._truth(value) for value in values)
                return self._chain(isinstance(op, ast.Or), truths, len(values))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self._choice(test, body, orelse)
            case ast.Call():
                return self._call(node)
        raise NotImplementedError(f"{ast.unparse(node)} is not lowered")

    def _named(self, name: str) -> Any:
        if name in self.names:
            found = self.names[name]
            if isinstance(found, FramePointer):
                return found
            data, *shape = (self.build.load(place) for place in found.places)
            return Array(found.kind[0], data, tuple(shape)) if shape else data
        assert name not in self.own, f"{name} is read before it is set"
        assert name in self.known, f"{name} is unknown"
        known = self.known[name]
        return (
            self.translation.constant(known) if isinstance(known, np.ndarray) else _constant(known)
        )

    def _attribute(self, node: ast.Attribute) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id not in self.own:
            return _constant(getattr(self.known[node.value.id], node.attr))  # np.inf, np.pi
        owner = self._value(node.value)
        assert isinstance(owner, FramePointer)
        return self._field(owner, node.attr)

    def _field(self, frame: FramePointer, name: str) -> Array:
        element, depth = ARRAY_KINDS[frame.kind.__annotations__[name]]
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
        return array if array.shape else self._load(array, place)

    def _load(self, array: Array, place: Any) -> Any:
        loaded = self.build.load(place)
        loaded.set_metadata("tbaa", self.translation.access[array.element])
        return loaded

    def _rest(self, node: ast.Subscript) -> Array:
        """A flat array from an index on."""
        array, bounds = self._value(node.value), node.slice
        assert isinstance(bounds, ast.Slice) and bounds.lower is not None
        assert bounds.upper is None and bounds.step is None
        assert isinstance(array, Array) and len(array.shape) == 1
        first = self._index(bounds.lower)
        data = self.build.gep(array.data, [first], inbounds=True)
        return Array(array.element, data, (self.build.sub(array.shape[0], first),))

    def _place(self, node: ast.Subscript) -> tuple[Array, Any]:
        """A row (an array that has a shape left) or the place of an element."""
        array = self._value(node.value)
        assert isinstance(array, Array)
        index = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        assert len(index) <= len(array.shape), "too many indices"
        offset = self._index(index[0])
        for level in range(1, len(array.shape)):
            offset = self.build.mul(offset, array.shape[level], flags=["nsw"])
            if level < len(index):
                offset = self.build.add(offset, self._index(index[level]), flags=["nsw"])
        place = self.build.gep(array.data, [offset], inbounds=True)
        return Array(array.element, place, array.shape[len(index) :]), place

    def _index(self, node: ast.expr) -> Any:
        value = self._as(self._value(node), INTEGER)
        assert not isinstance(value, ir.Constant) or value.constant >= 0, "negative index"
        return value

    def _unary(self, op: ast.unaryop, operand: ast.expr) -> Any:
        if isinstance(op, ast.Not):
            return self.build.not_(self._truth(operand))
        assert isinstance(op, ast.USub)
        value = self._value(operand)
        if isinstance(value, ir.Constant) and value.type != TRUTH:
            return _constant(-value.constant)
        return {DOUBLE: self.build.fneg, INTEGER: self.build.neg}[value.type](value)

    def _operation(self, op: ast.operator, left: Any, right: Any) -> Any:
        if left.type == right.type == INTEGER and not isinstance(op, ast.Div):
            build = {ast.Add: self.build.add, ast.Sub: self.build.sub, ast.Mult: self.build.mul,
                     ast.FloorDiv: self._quotient, ast.Mod: self._remainder}[type(op)]  # fmt: skip
        else:
            left, right = self._as(left, DOUBLE), self._as(right, DOUBLE)
            build = {ast.Add: self.build.fadd, ast.Sub: self.build.fsub,
                     ast.Mult: self.build.fmul, ast.Div: self.build.fdiv,
                     ast.Pow: self._power}[type(op)]  # fmt: skip
        return build(left, right)

    def _power(self, base: Any, exponent: Any) -> Any:
        return self.build.call(self.translation.pow, [base, exponent])

    def _quotient(self, left: Any, right: Any) -> Any:
        """Rounded down, as Python has it, not towards zero."""
        down = self.build.zext(self._is_off(left, right), INTEGER)
        return self.build.sub(self.build.sdiv(left, right), down)

    def _remainder(self, left: Any, right: Any) -> Any:
        """With the sign of the divisor, as Python has it."""
        added = self.build.select(self._is_off(left, right), right, ir.Constant(INTEGER, 0))
        return self.build.add(self.build.srem(left, right), added)

    def _is_off(self, left: Any, right: Any) -> Any:
        """Whether a division that rounds towards zero leaves a rest of the other sign."""
        rest, zero = self.build.srem(left, right), ir.Constant(INTEGER, 0)
        other_sign = self.build.icmp_signed("<", self.build.xor(rest, right), zero)
        return self.build.and_(other_sign, self.build.icmp_signed("!=", rest, zero))

    def _links(self, node: ast.Compare) -> Iterator[Any]:
        """The comparisons of a chain one by one."""
        left = self._value(node.left)
        for op, comparator in zip(node.ops, node.comparators, strict=True):
            right = self._value(comparator)
            yield self._compare(op, left, right)
            left = right

    def _compare(self, op: ast.cmpop, left: Any, right: Any) -> Any:
        symbol = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==",
                  ast.NotEq: "!="}[type(op)]  # fmt: skip
        if DOUBLE not in (left.type, right.type):
            assert left.type == right.type and left.type in (INTEGER, TRUTH)
            compare = self.build.icmp_unsigned if left.type == TRUTH else self.build.icmp_signed
            return compare(symbol, left, right)
        compare = self.build.fcmp_unordered if symbol == "!=" else self.build.fcmp_ordered
        return compare(symbol, self._as(left, DOUBLE), self._as(right, DOUBLE))

    def _chain(self, deciding: bool, truths: Iterable[Any], count: int) -> Any:
        """``and``, ``or``, comparisons in a row: the first truth that decides ends it.

        What the others are made of is written (`truths` is lazy) where they are asked for.
        """
        after, ends = self._new_block("decided"), []
        for number, truth in enumerate(truths, 1):
            if number == count:
                last = truth
                break
            further = self._new_block("further")
            ends.append(self.build.block)
            self.build.cbranch(truth, *((after, further) if deciding else (further, after)))
            self.build.position_at_end(further)
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
        assert kind in SCALARS.values()
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
        assert value.type == kind, f"{value.type} where {kind} is expected"
        return value

    def _given(self, value: Any, kind: Any) -> list[Any]:
        """The parts of `value` for a variable or parameter of this kind."""
        if isinstance(value, FramePointer):
            assert value.kind is kind, "another frame is expected"
        elif isinstance(value, Array):
            assert (value.element, len(value.shape)) == kind, "another array is expected"
        else:
            return [self._as(value, kind)]
        return _flat(value)

    # --- calls ------------------------------------------------------------------------------------
    def _call(self, node: ast.Call) -> Any:
        assert not node.keywords
        values = [self._value(argument) for argument in node.args]
        if isinstance(node.func, ast.Attribute):
            meant = getattr(self.known[_name(node.func.value)], node.func.attr)
            (value,) = values
            return self.build.call(self.translation.numpy[meant], [self._as(value, DOUBLE)])
        name = _name(node.func)
        assert name not in self.own
        if name in BUILTINS and name not in self.known:
            return getattr(self, f"_call_{name}")(*values)
        if self.known[name] is call_generated:
            return self._call_generated(*values)
        if self.known[name] in (bits_of, float_of):
            kinds = (DOUBLE, INTEGER) if self.known[name] is bits_of else (INTEGER, DOUBLE)
            return self.build.bitcast(self._as(values[0], kinds[0]), kinds[1])
        assert hasattr(self.known[name], "__native__"), f"{name} is no kernel"
        callee = self.translation.function(self.known[name])
        given: list[Any] = []
        for value, kind in zip(values, _kinds(self.known[name]), strict=True):
            given += self._given(value, kind)
        return self.build.call(callee, given)

    def _call_generated(self, address: Any, c: Array, t: Any, y: Array, out: Array) -> Any:
        data = [self._given(array, ARRAY_KINDS["Floats"])[0] for array in (c, y, out)]
        function = self.build.inttoptr(self._as(address, INTEGER), GENERATED.as_pointer())
        given = [data[0], self._as(t, DOUBLE), *data[1:]]
        return self.build.call(function, given, attrs=("nounwind",))

    def _call_abs(self, value: Any) -> Any:
        if value.type == INTEGER:
            return self._extreme(">", value, self.build.neg(value))
        return self.build.call(self.translation.fabs, [self._as(value, DOUBLE)])

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
        if value.type == DOUBLE:
            return self.build.fptosi(value, INTEGER)
        return self.build.zext(value, INTEGER) if value.type == TRUTH else value

    def _call_float(self, value: Any) -> Any:
        return value if value.type == DOUBLE else self._as(self._call_int(value), DOUBLE)

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
        assert -(2**63) <= value < 2**63
        return ir.Constant(INTEGER, value)
    assert isinstance(value, float), f"{value!r} is no number"
    return ir.Constant(DOUBLE, value)
