"""One run of an analysis: what a worker process executes."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

from fiv_cli.analyses.base import Analysis, Outcome, Request, Setup
from fiv_cli.analyses.variables import SLIP_BEYOND
from fiv_cli.errors import StorageError
from fiv_cli.flags import ENDED_EARLY
from fiv_cli.plate import ModeNotFoundError

if TYPE_CHECKING:
    from fiv_cli.analyses.rest.stiffness import Cost
    from fiv_cli.dynamics.system import System


def execute(request: Request) -> Outcome:
    """Run one point; whatever goes wrong is an `Outcome`, never an exception."""
    try:
        return answer(request)
    except ModeNotFoundError as error:
        return Outcome(status="failed", reason="hole_too_small", message=str(error))
    except Exception as error:
        return Outcome(
            status="failed",
            reason="internal_error",
            message=f"{type(error).__name__}: {error}\n{traceback.format_exc()}",
        )


def execute_all(requests: Sequence[Request]) -> Iterator[Outcome]:
    """`execute` each of the points of one analysis: at once what can be, as the same.

    Motions that take a time of their own are run when their outcomes are asked for; columns are
    filled when one more is asked for than there are.
    """
    blocks: dict[Hashable, list[Request]] = {}
    for request in requests:
        blocks.setdefault(request.setup.key, []).append(request)
    running = {key: _executed(block) for key, block in blocks.items()}
    for request in requests:
        yield next(running[request.setup.key])
    for answering in running.values():
        answering.close()


def _executed(block: Sequence[Request]) -> Generator[Outcome]:
    done = 0
    try:
        for outcome in answers(block):
            yield outcome
            done += 1
    except Exception:  # of one of them: which, and what, is found alone
        yield from map(execute, block[done:])


def answer(request: Request) -> Outcome:
    """Run one point; what goes wrong is raised."""
    (outcome,) = answers([request])
    return outcome.whole()


def answers(requests: Sequence[Request]) -> Iterator[Outcome]:
    """Run points that differ in parameters and starts alone; what goes wrong is raised."""
    from fiv_cli.analyses import get_analysis
    from fiv_cli.dynamics.system import build_system

    analysis, setup = get_analysis(requests[0].analysis), requests[0].setup
    if not analysis.generated:
        yield from (analysis.run(setup, request) for request in requests)
        return
    system = build_system(setup)
    singular = [
        setup.model.singular(system.known(request.parameters), setup.options)
        for request in requests
    ]
    sound = [request for request, (no, _) in zip(requests, singular, strict=True) if not no]
    is_limited = setup.law.reach < math.inf
    alone = not analysis.in_blocks or (is_limited and analysis.recorded)
    blocks = [[one] for one in sound] if alone else [sound] if sound else []
    found: Iterator[Outcome] = (
        _sound(outcome) for block in blocks for outcome in _outcomes(analysis, system, block)
    )
    if is_limited:
        found = _with_slips(system, sound, found, not analysis.recorded)
    for reason, message in singular:
        yield Outcome(status="failed", reason=reason, message=message) if reason else next(found)


def _outcomes(analysis: Analysis, system: System, block: Sequence[Request]) -> Iterable[Outcome]:
    found: Any = analysis.run(system, block if analysis.in_blocks else block[0])
    return found if analysis.in_blocks else [found]


def _sound(outcome: Outcome) -> Outcome:
    """The outcome; a failure where its motion went on to its end and its energies are no number."""
    residual = outcome.values.get("energy_residual", 0.0)
    if outcome.status != "ok" or outcome.reason in ENDED_EARLY or not math.isnan(residual):
        return outcome
    return Outcome(status="failed", reason="no_number", message="energy_residual is no number")


def _with_slips(
    system: System, requests: Sequence[Request], found: Iterator[Outcome], rests: bool
) -> Iterator[Outcome]:
    """The outcomes, with how fast a contact slips where the law is not known that far.

    `rests` : whether what is at rest has a part in them
    """
    from fiv_cli.analyses.rest.equilibria import slip_at_rest

    reach = system.setup.law.reach
    for request in requests:
        system.greatest_slip[:] = reach
        outcome = next(found)
        at_rest = slip_at_rest(system, request.parameters) if rests else 0.0
        greatest = max(system.greatest_slip.item(), at_rest)
        outcome.values[SLIP_BEYOND.name] = greatest if greatest > reach else math.nan
        yield outcome


def prepare(requests: Iterable[Request], announce: Callable[[str], None]) -> None:
    """Generate, compile and load all that `requests` need, once, before workers start.

    A request without a start stands for any start. `announce` is called with a sentence when
    something must be generated or compiled.
    """
    from fiv_cli.analyses import get_analysis

    seen = set()
    for request in requests:
        needs = _needs(request)
        if not get_analysis(request.analysis).generated or (request.setup.key, needs) in seen:
            continue
        seen.add((request.setup.key, needs))
        with _stored():
            for system in _systems(request, announce):
                _load(system, needs)
            if needs.motions:
                _load_kernels(needs, announce)


def cost_of_law(
    setup: Setup, points: Sequence[Mapping[str, float]], announce: Callable[[str], None]
) -> Cost:
    """Steps of the law of `setup` in those of Coulomb's, at each point; see `stiffness`."""
    from fiv_cli.analyses.rest.stiffness import cost_of

    with _stored():
        return cost_of(setup, points, announce)


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
    recorded = analysis.recorded
    starts_at_state = request.start is not None and request.start.kind == "state"
    return _Needs(
        equilibria=not (recorded and starts_at_state),
        motions=not analysis.linear,
        tangents=not (recorded or analysis.linear),
    )


def _systems(request: Request, announce: Callable[[str], None]) -> list[System]:
    """The compiled systems that a request needs: its own and, on demand, the averaged ones."""
    from fiv_cli.dynamics.system import build_system

    own = build_system(request.setup, announce)
    if request.settings.get("system") != "averaged":
        return [own]
    from fiv_cli.analyses.rest.averaging import averaged_system

    return [own, *(averaged_system(own, reversing, announce) for reversing in (False, True))]


def _load(system: System, needs: _Needs) -> None:
    """Bring machine code into memory, so that no point's time contains it.

    What is not needed is left out: the tangents are more than half of what there is to compile.
    """
    from fiv_cli.analyses.rest.equilibria import statics_of

    _ = system.tables
    if needs.equilibria:
        _ = system.jacobians
        statics_of(system)
    if needs.tangents:
        _ = system.tangent_tables


def _load_kernels(needs: _Needs, announce: Callable[[str], None]) -> None:
    """Bring into memory what motions of every system need."""
    from fiv_cli.analyses.attractor import side_by_side  # noqa: F401
    from fiv_cli.analyses.attractor.watch import load_watch
    from fiv_cli.dynamics.compiled import load_driver
    from fiv_cli.dynamics.recorder import load_recorder

    load_driver(announce)
    load_recorder(announce)
    if needs.tangents:
        load_watch(announce)
