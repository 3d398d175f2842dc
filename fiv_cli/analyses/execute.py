"""One run from plain values: what a worker process executes.

A `Request` holds names and numbers only, so it pickles cheaply and hashes exactly; the compiled
system is looked up (or loaded from the per-user cache) inside the worker.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from fiv_cli.analyses.base import Outcome, SolverSettings, Start
from fiv_cli.dynamics.schedule import STEADY, Schedule
from fiv_cli.errors import StorageError
from fiv_cli.plate import ModeNotFoundError

if TYPE_CHECKING:
    from fiv_cli.dynamics.system import System


@dataclass(frozen=True)
class Request:
    """One point of one analysis.

    Attributes
    ----------
    model, law : contract names (``tanh of coulomb`` for a regularised law)
    options : every option of the model
    parameters : every parameter of the model and of the law, SI
    analysis : kind
    settings : every setting of the analysis
    solver : integrator settings
    start : None where the analysis has no starts
    schedule : parameters that vary in time
    """

    model: str
    law: str
    options: Mapping[str, str]
    parameters: Mapping[str, float]
    analysis: str
    settings: Mapping[str, object]
    solver: SolverSettings = field(default_factory=SolverSettings)
    start: Start | None = None
    schedule: Schedule = STEADY


@dataclass(frozen=True)
class Plain:
    """What an analysis that needs no generated code knows of the model: its options."""

    options: Mapping[str, str]


def execute(request: Request) -> Outcome:
    """Run one point; whatever goes wrong is an `Outcome`, never an exception."""
    from fiv_cli.analyses import get_analysis
    from fiv_cli.analyses.rest.surface import nodes_at_r0
    from fiv_cli.dynamics.system import System

    try:
        analysis = get_analysis(request.analysis)
        system = _system(request) if analysis.generated else Plain(request.options)
        nodes = nodes_at_r0(system, request.parameters) if isinstance(system, System) else []
        if nodes:
            said = f"mode {', '.join(nodes)} has a node at r0 = {request.parameters['r0']!r} m"
            return Outcome(status="failed", reason="node_at_r0", message=said)
        return analysis.run(
            system, request.parameters, request.start, request.settings, request.solver
        )
    except ModeNotFoundError as error:
        return Outcome(status="failed", reason="hole_too_small", message=str(error))
    except Exception as error:
        return Outcome(
            status="failed",
            reason="internal_error",
            message=f"{type(error).__name__}: {error}\n{traceback.format_exc()}",
        )


def prepare(requests: Iterable[Request], announce: Callable[[str], None]) -> None:
    """Generate, compile and load all that `requests` need, once, before workers start.

    A request without a start stands for any start. `announce` is called with a sentence when
    something must be generated or compiled.
    """
    from fiv_cli.analyses import get_analysis
    from fiv_cli.dynamics.system import system_key

    seen = set()
    for request in requests:
        if not get_analysis(request.analysis).generated:
            continue
        key = system_key(
            request.model,
            request.law,
            request.options,
            request.parameters,
            request.solver,
            request.schedule,
        )
        needs = _needs(request)
        if (key, needs) not in seen:
            seen.add((key, needs))
            with _stored():
                for system in _systems(request, announce):
                    _load(system, request.parameters, needs)
                if needs.motions:
                    _load_kernels(needs, announce)


@contextmanager
def _stored() -> Iterator[None]:
    """StorageError where compiled code cannot be kept."""
    from fiv_cli.codegen.cache import cache_root

    try:
        yield
    except OSError as error:
        raise StorageError(
            f"{cache_root()}: compiled code cannot be kept there: {error.strerror or error}\n"
            "next: free some space, or name another folder: FIV_CACHE_DIR=FOLDER in the environment"
        ) from error


class _Needs(NamedTuple):
    """What a request needs beside the flow: equilibria, motions, tangents carried along them."""

    equilibria: bool
    motions: bool
    tangents: bool


def _needs(request: Request) -> _Needs:
    from fiv_cli.analyses import get_analysis

    analysis = get_analysis(request.analysis)
    recorded = analysis.recorded(request.schedule)
    starts_at_state = request.start is not None and request.start.kind == "state"
    return _Needs(
        equilibria=not (recorded and starts_at_state),
        motions=not analysis.linear,
        tangents=not (recorded or analysis.linear),
    )


def _systems(request: Request, announce: Callable[[str], None]) -> list[System]:
    """The compiled systems that a request needs: its own and, on demand, the averaged ones."""
    own = _system(request, announce)
    if request.settings.get("system") != "averaged":
        return [own]
    from fiv_cli.analyses.rest.averaging import averaged_system

    averages = [averaged_system(own, request.parameters, r, announce) for r in (False, True)]
    return [own, *averages]


def _load(system: System, parameters: Mapping[str, float], needs: _Needs) -> None:
    """Bring machine code into memory, so that no point's time contains it.

    What is not needed is left out: the tangents are more than half of what there is to compile.
    """
    from fiv_cli.analyses.rest.equilibria import statics_of

    _ = system.tables
    if needs.equilibria:
        _ = system.jacobians
        statics_of(system, parameters)
    if needs.tangents:
        _ = system.tangent_tables


def _load_kernels(needs: _Needs, announce: Callable[[str], None]) -> None:
    """Bring into memory what motions of every system need."""
    from fiv_cli.analyses.attractor import steady_state  # noqa: F401
    from fiv_cli.analyses.attractor.settling import load_settling
    from fiv_cli.analyses.motion import recording  # noqa: F401
    from fiv_cli.dynamics.compiled import load_driver

    load_driver(announce)
    if needs.tangents:
        load_settling(announce)


def _system(request: Request, announce: Callable[[str], None] = lambda sentence: None) -> System:
    from fiv_cli.dynamics.system import build_system

    return build_system(
        request.model,
        request.law,
        request.options,
        request.parameters,
        request.solver,
        announce,
        request.schedule,
    )
