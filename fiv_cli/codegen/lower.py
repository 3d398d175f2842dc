"""Generated text to machine code.

LLVM compiles the assembly of `assembly.py` to an object file. Its optimiser works on whole
functions only: in the pieces of long ones there is nothing to find for it.
"""

from __future__ import annotations

from functools import cache

import llvmlite.binding as llvm

# Texts of more characters are compiled the quick way, in a third of the time. The numbers are the
# same, a step takes up to 1.15 times as long.
LARGE = 1_500_000


@cache
def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def target_machine(effort: int = 2) -> llvm.TargetMachine:
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
    from fiv_cli.codegen.assembly import assembly

    machine = target_machine(effort=0 if len(text) > LARGE else 2)
    module = llvm.parse_assembly(assembly(text, fuses()))
    module.verify()
    _optimise(module, machine)
    return bytes(machine.emit_object(module))


def compile_entry(text: str, entry: str) -> bytes:
    """Object code of LLVM text, in which one function alone is called from elsewhere.

    LLVM is told so: what every function returns in the same way, or hands on to nobody, goes.

    Raises
    ------
    TypeError
        it may raise an exception of Python: there is nobody to take it.
    """
    machine, module = target_machine(effort=3), llvm.parse_assembly(text)
    module.verify()
    for function in module.functions:
        if not function.is_declaration and function.name != entry:
            function.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    if any(constant.name.startswith(".const.pickledata") for constant in module.global_variables):
        raise TypeError(f"{entry}: kernels raise no exceptions")
    return bytes(machine.emit_object(module))


def load_object(code: bytes) -> llvm.ExecutionEngine:
    """Execution engine holding `code`; keep it alive as long as its addresses are used."""
    machine = target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


def _optimise(module: llvm.ModuleRef, machine: llvm.TargetMachine) -> None:
    """Simplify every function that is not a piece."""
    from fiv_cli.codegen.assembly import is_piece

    options = llvm.create_pipeline_tuning_options(speed_level=1)
    builder = llvm.create_pass_builder(machine, options)
    passes = builder.getFunctionPassManager()
    for function in module.functions:
        if not function.is_declaration and not is_piece(function.name):
            passes.run(function, builder)
