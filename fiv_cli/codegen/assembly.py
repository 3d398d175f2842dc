"""Generated text to LLVM assembly.

The text is straight-line but for a loop (see `emit.py`), so reading it takes a tokeniser and a few
rules, and writing it one line of assembly per operation: nothing is typed or inferred. There is no
fast-math: what is computed is what the text says, operation by operation. Only a sum with a product
is one operation with one rounding, where the processor has it: half the time that the next one
waits.

LLVM's register allocator takes time with the square of a function's length. The tangent step of a
disc has tens of thousands of operations and is therefore cut into *pieces*: functions of their own,
a few statements each, called one after the other. What a later piece needs of an earlier one goes
through memory, where an allocator would have put most of it too: through ``out`` if it is stored
there anyway, else through the workspace ``w``.

What a function writes to ``lanes`` it computes of `LANES` vectors at once, what it writes to
``nodes`` of `NODES`.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from llvmlite import ir

from fiv_cli.codegen.codes import LANES, NODES

LIBRARY = ("exp", "log", "sin", "cos", "tanh", "asin", "pow")  # called in the C library
# A function of more characters is cut, into pieces of so many. The lumped models' are not so long.
WHOLE, PIECE = 180_000, 3000

REAL = ir.DoubleType()
VECTORS = {"lanes": ir.VectorType(REAL, LANES), "nodes": ir.VectorType(REAL, NODES)}
BUILT_IN = ("sqrt", "rint")  # functions of one number that LLVM knows
POINTER = str(REAL.as_pointer())  # as this LLVM writes it
CONVOLVE = re.compile(r"convolve\(v, (.*?), (\d+), (\d+)\)")
ROW = re.compile(r"(?:(\d+) \* )?k(?: ([-+]) (\d+))?")  # of an array, in a loop over k
OPERATIONS = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
TOKEN = re.compile(r"[^\W\d]\w*(?:\[[^]]+\])?|[\d.]+(?:e[+-]?\d+)?|[-+*/(),]")


def assembly(text: str, fused: bool) -> str:
    """LLVM assembly of every function in `text`; `fused`: multiply and add in one operation."""
    parts = [_declaration(name) for name in LIBRARY]
    for kind in (REAL, *VECTORS.values()):
        parts += [f"declare {kind} @{_builtin(name, kind)}({kind})" for name in BUILT_IN]
        parts.append(f"declare {kind} @{_builtin('fma', kind)}({kind}, {kind}, {kind})")
    for width, stride in sorted({found[1:] for found in CONVOLVE.findall(text)}):
        parts += _convolution(int(width), int(stride), fused)
    for name, target, statements in _functions(text):
        parts += _Function(name, target, statements, fused).written()
    return "\n".join(parts) + "\n"


def _convolution(width: int, stride: int, fused: bool) -> list[str]:
    """Sums of the products of rows 2 to k - 2 of a table with rows k - 2 to 2; see `table.py`."""
    kind = VECTORS["lanes"]
    places = [*range(0, width - LANES, LANES), width - LANES]  # the last two may overlap
    totals = (f"%total{i} = phi {kind} [zeroinitializer, %entry], [%sum{i}, %rows]" for i in places)
    name, arguments = f"@convolve.{width}.{stride}", f"{POINTER} noalias %v, i64 %k"
    lines = [
        f"define internal void {name}({arguments}) noinline nounwind {{\nentry:",
        "%last = sub i64 %k, 2\nbr label %rows\nrows:",
        "%j = phi i64 [2, %entry], [%next, %rows]",
        *totals,
        "%rest = sub i64 %k, %j",
        *_column("left", "%j", stride, 0, places),
        *_column("right", "%rest", stride, width, places),
    ]
    for i in places:
        lines += [f"%{at}{i} = load {kind}, {_vector_at(at, i)}" for at in ("left", "right")]
        if fused:
            given = ", ".join(f"{kind} %{name}{i}" for name in ("left", "right", "total"))
            lines.append(f"%sum{i} = call {kind} @{_builtin('fma', kind)}({given})")
        else:
            lines.append(f"%product{i} = fmul {kind} %left{i}, %right{i}")
            lines.append(f"%sum{i} = fadd {kind} %total{i}, %product{i}")
    lines.append("%next = add i64 %j, 1\n%more = icmp slt i64 %j, %last")
    lines.append("br i1 %more, label %rows, label %done\ndone:")
    lines += _column("sum", "%k", stride, 2 * width, places)
    lines += [f"store {kind} %sum{i}, {_vector_at('sum', i)}" for i in places]
    return [*lines, "ret void\n}"]


def _column(name: str, row: str, stride: int, column: int, places: Sequence[int]) -> Iterator[str]:
    """Addresses of vectors in a row of a table, from a column on."""
    yield f"%{name}.row = mul nsw i64 {row}, {stride}"
    yield f"%{name}.at = add nsw i64 %{name}.row, {column}"
    yield f"%{name} = getelementptr double, {POINTER} %v, i64 %{name}.at"
    for i in places:
        yield f"%{name}.{i}.number = getelementptr double, {POINTER} %{name}, i64 {i}"
        kind = VECTORS["lanes"].as_pointer()
        yield f"%{name}.{i} = bitcast {POINTER} %{name}.{i}.number to {kind}"


def _vector_at(name: str, place: int) -> str:
    return f"{VECTORS['lanes'].as_pointer()} %{name}.{place}, align 8"


def is_piece(name: str) -> bool:
    """Whether a function in the assembly is a piece of one in the text."""
    return "." in name


def _declaration(name: str) -> str:
    """A function of the C library; it only computes, so sine and cosine become one call."""
    arguments = "double, double" if name == "pow" else "double"
    return f"declare double @{name}({arguments}) nounwind readnone"


def _builtin(name: str, kind: ir.Type) -> str:
    """What LLVM itself makes of this function."""
    return f"llvm.{name}.f64" if kind is REAL else f"llvm.{name}.v{kind.count}f64"


def _functions(text: str) -> Iterator[tuple[str, str, list[str]]]:
    """Name, array that is written, and statements of every function, without comments."""
    for part in f"\n{text}".split("\ndef ")[1:]:
        head, *lines = part.split("\n")
        bare = (line.partition("#")[0].strip() for line in lines)
        name, _, arguments = head.partition("(")
        yield name, arguments.rpartition(" ")[2].removesuffix("):"), [line for line in bare if line]


class _Home(NamedTuple):
    """Where in memory a value is: an array, a place in it, and the piece that puts it there."""

    array: str
    place: str
    piece: int


class _Function:
    """One function of the text.

    Attributes
    ----------
    target : array that it writes: ``out``, or one of `VECTORS`
    kind : of every value that is computed
    """

    def __init__(self, name: str, target: str, statements: list[str], fused: bool) -> None:
        self.name, self.target, self.fused = name, target, fused
        self.kind = VECTORS.get(target, REAL)
        self.pointer = str(self.kind.as_pointer())
        loops = any(statement.startswith("for ") for statement in statements)
        self.is_whole = loops or sum(map(len, statements)) <= WHOLE
        self.pieces: list[_Piece] = []
        self.makers: dict[str, _Piece] = {}  # which piece computes a value
        self.homes: dict[str, _Home] = {}
        self.n_words = 0  # of the workspace
        length = PIECE
        for statement in statements:
            if not self.pieces or (length >= PIECE and not self.is_whole):
                self.pieces.append(_Piece(self))
                length = 0
            self.pieces[-1].add(statement)
            length += len(statement)
        self.pieces[-1].end_loop()

    def home(self, name: str) -> _Home:
        """Where the latest piece finds a value of an earlier one, put there if need be."""
        home = self.homes.get(name)
        if home is None or home.piece >= self.pieces[-1].number:
            maker = self.makers[name]
            home = self.homes[name] = _Home("w", str(self.n_words), maker.number)
            maker.store(maker.values[name], "w", home.place)
            self.n_words += 1
        return home

    def written(self) -> list[str]:
        """The function and its pieces."""
        arguments = (
            f"{POINTER} noalias %c, double %t, {POINTER} noalias %y, "
            f"{self.pointer} noalias %{self.target}"
        )
        head = f"define void @{self.name}({arguments}) {{\nentry:"
        if self.is_whole:
            return [head, *(line for piece in self.pieces for line in piece.lines), "ret void\n}"]
        lines, calls, with_workspace = [], [], f"{arguments}, {self.pointer} noalias %w"
        for piece in self.pieces:
            name = f"@{self.name}.{piece.number}"
            begin = f"define internal void {name}({with_workspace}) noinline nounwind {{\nentry:"
            lines += [begin, *piece.lines, *piece.stores, "ret void\n}"]
            calls.append(f"call void {name}({with_workspace.replace(' noalias', '')})")
        workspace = f"%w = alloca {self.kind}, i64 {max(self.n_words, 1)}"
        return [*lines, head, workspace, *calls, "ret void\n}"]


class _Product(NamedTuple):
    """A value, or a value and what it is still to be multiplied with."""

    value: str
    factor: str = ""


class _Piece:
    """Some statements of a function, or all of them.

    Attributes
    ----------
    number : of the piece
    lines : its assembly
    stores : what follows at the end of a piece: a store between two loads makes LLVM ask whether
        they may change places
    values : names, literals and inputs -> their value in the assembly; what comes from memory
        does not change while the function runs and is read once
    loops, after : how many loops have begun, and where the one that is on ends
    """

    def __init__(self, function: _Function) -> None:
        self.function = function
        self.number = len(function.pieces)
        self.lines: list[str] = []
        self.stores = self.lines if function.is_whole else []
        self.kind, self.pointer = function.kind, function.pointer
        self.values: dict[str, str] = {}
        self.loops, self.after = 0, ""
        self._count = 0
        self._tokens: list[str] = []
        self._at = 0

    def add(self, statement: str) -> None:
        """Write the assembly of one statement."""
        if statement.startswith("for "):
            self._begin_loop(*re.findall(r"\d+", statement))
        elif call := CONVOLVE.fullmatch(statement):
            self._convolve(*call.groups())
        elif statement.startswith("v = "):
            room = statement.rpartition(" ")[2]
            self.lines.append(f"%v = alloca {REAL}, i64 {room}, align 64")
        else:
            self._assign(statement)

    def _begin_loop(self, first: str, after: str) -> None:
        """What follows is gone through for each k from `first`, up to `after`."""
        self.end_loop()
        number, before = self.loops, f"after{self.loops - 1}" if self.loops else "entry"
        self.lines += [
            f"br label %orders{number}",
            f"orders{number}:",
            f"%k{number} = phi i64 [{first}, %{before}], [%next{number}, %orders{number}]",
            f"%next{number} = add nsw i64 %k{number}, 1",
        ]
        self.values["k"] = self._new(f"sitofp i64 %k{number} to double")
        self.loops, self.after = number + 1, after

    def end_loop(self) -> None:
        """What follows comes after the loop, if there is one."""
        if not self.after:
            return
        number = self.loops - 1
        self.lines += [
            f"%more{number} = icmp slt i64 %next{number}, {self.after}",
            f"br i1 %more{number}, label %orders{number}, label %after{number}",
            f"after{number}:",
        ]
        self.after = ""
        moving = re.compile(r"\bk\b")
        self.values = {text: at for text, at in self.values.items() if not moving.search(text)}

    def _convolve(self, order: str, width: str, stride: str) -> None:
        at = self._index(order)
        self.lines.append(f"call void @convolve.{width}.{stride}({POINTER} %v, i64 {at})")

    def _index(self, text: str) -> str:
        """A place in an array: a number, or one that moves with k."""
        found = ROW.fullmatch(text)
        if not found:
            return text
        stride, sign, offset = found.groups()
        at = self._new(f"mul nsw i64 %k{self.loops - 1}, {stride or 1}")
        return self._new(f"add nsw i64 {at}, {sign.strip('+')}{offset}")

    def _assign(self, statement: str) -> None:
        """Write the assembly of ``target = expression``."""
        target, _, text = statement.partition(" = ")
        self._tokens, self._at = [*TOKEN.findall(text), ""], 0
        value = self._sum()
        if self._at != len(self._tokens) - 1:
            raise ValueError(f"{statement}: not understood from {self._tokens[self._at]!r} on")
        if not target.endswith("]"):
            self._define(target, value)
            return
        array, _, place = target[:-1].partition("[")
        self.store(value, array, place)
        if text in self.function.makers:
            self.function.homes.setdefault(text, _Home(array, place, self.number))

    def _define(self, name: str, value: str) -> None:
        self.values[name] = value
        self.function.makers[name] = self
        self.function.homes.pop(name, None)

    def store(self, value: str, array: str, place: str) -> None:
        """Put a value into memory."""
        kind, pointer, at = self.kind, self.pointer, self._index(place)
        address = f"%{array}.{at.strip('%')}"
        self.stores.append(f"{address} = getelementptr {kind}, {pointer} %{array}, i64 {at}")
        self.stores.append(f"store {kind} {value}, {pointer} {address}, align 8")

    def _load(self, array: str, place: str) -> str:
        if array in ("c", "y"):
            address = self._new(f"getelementptr double, {POINTER} %{array}, i64 {place}")
            return self._in_lanes(self._new(f"load double, {POINTER} {address}"))
        kind, pointer, at = self.kind, self.pointer, self._index(place)
        address = self._new(f"getelementptr {kind}, {pointer} %{array}, i64 {at}")
        return self._new(f"load {kind}, {pointer} {address}, align 8")

    def _in_lanes(self, value: str) -> str:
        """A number, in every lane where there are several."""
        if self.kind is REAL:
            return value
        first = self._new(f"insertelement {self.kind} undef, double {value}, i32 0")
        lanes = f"<{self.kind.count} x i32> zeroinitializer"
        return self._new(f"shufflevector {self.kind} {first}, {self.kind} undef, {lanes}")

    def _new(self, operation: str) -> str:
        value = f"%{self._count}"
        self._count += 1
        self.lines.append(f"{value} = {operation}")
        return value

    # --- expressions ------------------------------------------------------------------------------
    def _sum(self) -> str:
        return self._done(self._total())

    def _total(self) -> _Product:
        left = self._product()
        while (sign := self._tokens[self._at]) == "+" or sign == "-":
            self._at += 1
            left = _Product(self._added(left, sign, self._product()))
        return left

    def _added(self, left: _Product, sign: str, right: _Product) -> str:
        if self.function.fused and right.factor:
            value = right.value if sign == "+" else self._new(f"fneg {self.kind} {right.value}")
            return self._fused(value, right.factor, self._done(left))
        if self.function.fused and left.factor:
            value = right.value if sign == "+" else self._new(f"fneg {self.kind} {right.value}")
            return self._fused(left.value, left.factor, value)
        right_value = self._done(right)
        return self._new(f"{OPERATIONS[sign]} {self.kind} {self._done(left)}, {right_value}")

    def _fused(self, *operands: str) -> str:
        given = ", ".join(f"{self.kind} {operand}" for operand in operands)
        return self._new(f"call {self.kind} @{_builtin('fma', self.kind)}({given})")

    def _done(self, product: _Product) -> str:
        if not product.factor:
            return product.value
        return self._new(f"fmul {self.kind} {product.value}, {product.factor}")

    def _product(self) -> _Product:
        left = self._first()
        while (sign := self._tokens[self._at]) == "*" or sign == "/":
            self._at += 1
            value, right = self._done(left), self._factor()
            if sign == "*":
                left = _Product(value, right)
            else:
                left = _Product(self._new(f"fdiv {self.kind} {value}, {right}"))
        return left

    def _first(self) -> _Product:
        """The first factor; in parentheses it may itself be a product."""
        if self._tokens[self._at] != "(":
            return _Product(self._factor())
        self._at += 1
        inner = self._total()
        self._at += 1
        return inner

    def _factor(self) -> str:
        token = self._tokens[self._at]
        self._at += 1
        if token in self.values:
            return self.values[token]
        if token == "-":
            return self._negated()
        if token == "(":
            inner = self._sum()
            self._at += 1
            return inner
        if self._tokens[self._at] == "(":
            return self._call(token)
        value = self.values[token] = self._leaf(token)
        return value

    def _negated(self) -> str:
        token = self._tokens[self._at]
        if token[0].isdigit():
            self._at += 1
            return self._literal(f"-{token}")
        inner = self._factor()
        return self._new(f"fneg {self.kind} {inner}")

    def _call(self, name: str) -> str:
        arguments = []
        while self._tokens[self._at] != ")":
            self._at += 1  # the parenthesis or a comma
            arguments.append(self._sum())
        self._at += 1
        if name in BUILT_IN:
            called = _builtin(name, self.kind)
            return self._new(f"call {self.kind} @{called}({self.kind} {arguments[0]})")
        if self.kind is REAL:
            return self._called(name, arguments)
        value = "undef"
        for lane in range(self.kind.count):
            taken = [self._new(f"extractelement {self.kind} {a}, i32 {lane}") for a in arguments]
            found = self._called(name, taken)
            value = self._new(f"insertelement {self.kind} {value}, double {found}, i32 {lane}")
        return value

    def _called(self, name: str, arguments: list[str]) -> str:
        """What a function of the C library makes of numbers."""
        given = ", ".join(f"double {argument}" for argument in arguments)
        return self._new(f"call double @{name}({given})")

    def _leaf(self, token: str) -> str:
        """A literal, the time, an entry of an array, or a value of an earlier piece."""
        if token[0].isdigit():
            return self._literal(token)
        if token == "t":
            return self._in_lanes("%t")
        if token.endswith("]"):
            array, _, place = token[:-1].partition("[")
            return self._load(array, place)
        home = self.function.home(token)
        return self._load(home.array, home.place)

    def _literal(self, text: str) -> str:
        """A number with all its bits."""
        bits = f"0x{struct.pack('>d', float(text)).hex().upper()}"
        if self.kind is REAL:
            return bits
        return f"<{', '.join([f'double {bits}'] * self.kind.count)}>"
