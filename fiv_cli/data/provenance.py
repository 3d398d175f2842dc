"""Global attributes of a dataset: where its numbers come from, and nothing that changes."""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import asdict, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import fiv_cli
from fiv_cli.analyses import get_analysis
from fiv_cli.case.assumed import assumed_of_contacts
from fiv_cli.case.case import Case
from fiv_cli.codegen import NUMERICS_VERSION
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

PACKAGES = ("numpy", "scipy", "llvmlite", "sympy", "xarray", "netCDF4")


def provenance(case: Case, fingerprint: str) -> dict[str, object]:
    """Global attributes of the dataset of `case`."""
    model = get_model(case.model)
    assumptions = assumed_of_contacts(case)
    laws = next((axis.values for axis in case.axes if axis.kind == "law"), (case.law,))
    return {
        "Conventions": "CF-1.11",
        "title": case.title or case.source,
        "reference": case.reference,
        "source": f"fiv {fiv_cli.__version__}",
        "history": command_of(case),
        "model": case.model,
        "model_reference": model.reference,
        "model_numerics_version": model.numerics_version,
        "law": ", ".join(laws),
        "law_numerics_version": ", ".join(str(get_law(law).numerics_version) for law in laws),
        "numerics_version": NUMERICS_VERSION,
        "analyses": ", ".join(f"{spec.name} ({spec.kind})" for spec in case.analyses),
        "analyses_json": {
            spec.name: {"kind": spec.kind, "title": get_analysis(spec.kind).title}
            | {"settings": {name: _plain(value) for name, value in spec.told.items()}}
            for spec in case.analyses
        },
        "parameters_json": case.parameters,
        "options_json": case.options,
        "starts_json": {start.label: start.kind for start in case.starts},
        "figures_json": json.dumps([asdict(figure) for figure in case.figures]),
        "assumed": case.assumed,
        "case": case.text,
        "overrides": case.overrides,
        "fingerprint": fingerprint,
        "solver_json": asdict(case.solver),
        **({"assumed_of_contacts": assumptions} if assumptions else {}),
        **({"own_json": _texts(case)} if case.own else {}),
        **({"schedule_json": dict(case.schedule.curves)} if case.schedule.curves else {}),
        "packages_json": {name: _version(name) for name in PACKAGES},
    }


@cache
def surroundings() -> dict[str, str]:
    """What decides the bits of a number beside the case: program, packages, processor, C library.

    Also on another machine, whose own is then asked for.
    """
    from fiv_cli.codegen.lower import machine_description

    program = sorted(Path(fiv_cli.__file__).parent.rglob("*.py"))
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in program)).hexdigest()
    return {
        "fiv": f"{fiv_cli.__version__} ({digest[:8]})",
        "Python": platform.python_version(),
        "C library": " ".join(platform.libc_ver()),
        "processor": machine_description(),
        **{name: _version(name) for name in ("numba", *PACKAGES)},
    }


def command_of(case: Case) -> str:
    """What was typed to run the case."""
    files = dict.fromkeys(f"--with {o.path}" for o in case.own.values() if o.is_named)
    changes = (f"--set {override!r}" for override in case.overrides)
    return " ".join(["fiv run", case.source, *files, *changes])


def _texts(case: Case) -> dict[str, object]:
    """The files of a model and laws that are not in the box: what stood there, and its hash."""
    files = dict.fromkeys(case.own.values())
    return {
        origin.path: {
            "holds": [name for name, other in case.own.items() if other == origin],
            "sha256": origin.digest,
            "text": origin.text,
        }
        for origin in files
    }


def _plain(value: object) -> object:
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
