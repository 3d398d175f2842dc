"""Generated text to machine code.

The text is straight-line (see `emit.py`); this reads it with `ast`, writes LLVM IR and lets LLVM
compile that to an object file. Nothing is typed or inferred, so a thousand lines take a fraction
of a second where a general front end takes many. There is no fast-math and no contraction to
fused multiply-add: the object computes what the text says, operation by operation.
"""

from __future__ import annotations

import ast
from functools import cache
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir

DOUBLE = ir.DoubleType()
POINTER = DOUBLE.as_pointer()
SIGNATURE = ir.FunctionType(ir.VoidType(), (POINTER, DOUBLE, POINTER, POINTER))
# Beyond so many characters registers are allocated the quick way: the good way takes time with the
# square of the length. The numbers are the same, each step takes some 1.6 times as long.
LARGE = 1_500_000
LIBRARY = ("exp", "log", "sin", "cos", "tanh", "asin", "pow")  # called in the C library


@cache
def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def target_machine(effort: int = 2) -> Any:
    """LLVM's description of this processor; an execution engine takes its own."""
    _initialise()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=effort,
        reloc="pic",
        codemodel="jitdefault",
        jit=True,
    )


def machine_description() -> str:
    """What, beside the text, decides the object code."""
    versions = ".".join(map(str, llvm.llvm_version_info))
    features = llvm.get_host_cpu_features().flatten()
    return f"llvm {versions} {llvm.get_host_cpu_name()} {features}"


@cache
def fuses() -> bool:
    """Whether this processor multiplies and adds in one instruction."""
    features = llvm.get_host_cpu_features()
    return bool(features.get("fma") or features.get("neon"))


def compile_text(text: str) -> bytes:
    """Object code of every function in `text`."""
    machine = target_machine(effort=0 if len(text) > LARGE else 2)
    module = _optimised(str(_to_ir(text)), machine)
    return bytes(machine.emit_object(module))


def load_object(code: bytes) -> Any:
    """Execution engine holding `code`; keep it alive as long as its addresses are used."""
    machine = target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


def _optimised(source: str, machine: Any) -> Any:
    module = llvm.parse_assembly(source)
    module.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return module


def _to_ir(text: str) -> ir.Module:
    module = ir.Module(name="fiv")
    library = {name: _declare(module, name) for name in LIBRARY}
    library["sqrt"] = module.declare_intrinsic("llvm.sqrt", [DOUBLE])
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef):
            _Lowering(module, node, library).run()
    return module


def _declare(module: ir.Module, name: str) -> ir.Function:
    """A function of the C library; it only computes, so sine and cosine become one call."""
    count = 2 if name == "pow" else 1
    function = ir.Function(module, ir.FunctionType(DOUBLE, (DOUBLE,) * count), name)
    for attribute in ("readnone", "nounwind"):
        function.attributes.add(attribute)
    return function


class _Lowering:
    """One function of the text."""

    def __init__(
        self, module: ir.Module, definition: ast.FunctionDef, library: dict[str, Any]
    ) -> None:
        self.function = ir.Function(module, SIGNATURE, definition.name)
        for argument, name in zip(self.function.args, ("c", "t", "y", "out"), strict=True):
            argument.name = name
            if name != "t":
                argument.add_attribute("noalias")
        self.definition = definition
        self.library = library
        self.builder = ir.IRBuilder(self.function.append_basic_block())
        self.names: dict[str, Any] = {"t": self.function.args[1]}
        self.loaded: dict[tuple[str, int], Any] = {}

    def run(self) -> None:
        for statement in self.definition.body:
            assert isinstance(statement, ast.Assign)
            self._assign(statement.targets[0], self._value(statement.value))
        self.builder.ret_void()

    def _assign(self, target: ast.expr, value: Any) -> None:
        if isinstance(target, ast.Name):
            self.names[target.id] = value
        else:
            assert isinstance(target, ast.Subscript)
            self.builder.store(value, self._place(target))

    def _place(self, node: ast.Subscript) -> Any:
        name, index = _subscript(node)
        base = dict(zip(("c", "t", "y", "out"), self.function.args, strict=True))[name]
        return self.builder.gep(base, [ir.Constant(ir.IntType(64), index)])

    def _value(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=value):
                return ir.Constant(DOUBLE, float(value))  # type: ignore[arg-type]
            case ast.Name(id=name):
                return self.names[name]
            case ast.Subscript():
                return self._load(node)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self._negated(operand)
            case ast.BinOp(left=left, op=op, right=right):
                return self._fused(node) or self._operation(
                    op, self._value(left), self._value(right)
                )
            case ast.Call(func=ast.Name(id=name), args=args):
                return self.builder.call(self.library[name], [self._value(a) for a in args])
        raise NotImplementedError(ast.dump(node))

    def _negated(self, operand: ast.expr) -> Any:
        if isinstance(operand, ast.Constant):
            return ir.Constant(DOUBLE, -float(operand.value))  # type: ignore[arg-type]
        return self.builder.fneg(self._value(operand))

    def _fused(self, node: ast.BinOp) -> Any:
        """A sum with a product, with one rounding, where the processor has that instruction."""
        if not fuses() or not isinstance(node.op, ast.Add | ast.Sub):
            return None
        if isinstance(node.right, ast.BinOp) and isinstance(node.right.op, ast.Mult):
            added = self._value(node.left)
            factors = self._value(node.right.left), self._value(node.right.right)
            if isinstance(node.op, ast.Sub):
                factors = self.builder.fneg(factors[0]), factors[1]
        elif isinstance(node.left, ast.BinOp) and isinstance(node.left.op, ast.Mult):
            factors = self._value(node.left.left), self._value(node.left.right)
            added = self._value(node.right)
            if isinstance(node.op, ast.Sub):
                added = self.builder.fneg(added)
        else:
            return None
        return self.builder.fma(*factors, added)

    def _operation(self, op: ast.operator, left: Any, right: Any) -> Any:
        build = {
            ast.Add: self.builder.fadd,
            ast.Sub: self.builder.fsub,
            ast.Mult: self.builder.fmul,
            ast.Div: self.builder.fdiv,
        }[type(op)]
        return build(left, right)

    def _load(self, node: ast.Subscript) -> Any:
        """Inputs do not change while the function runs: each is read once."""
        key = _subscript(node)
        if key not in self.loaded:
            self.loaded[key] = self.builder.load(self._place(node))
        return self.loaded[key]


def _subscript(node: ast.Subscript) -> tuple[str, int]:
    assert isinstance(node.value, ast.Name)
    assert isinstance(node.slice, ast.Constant)
    return node.value.id, int(node.slice.value)  # type: ignore[arg-type]
