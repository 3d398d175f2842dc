"""The generated module of a model with a law: text, tables, machine code.

What is cached per user: one JSON file with the text and the tables (made once, with SymPy), and
one object file per text. Loading both takes milliseconds and imports neither SymPy nor LLVM's
optimiser.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fiv_cli.codegen import NUMERICS_VERSION, cache
from fiv_cli.codegen.codes import OTHER_POWER
from fiv_cli.codegen.setup import Setup
from fiv_cli.errors import UsageError

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

    from fiv_cli.codegen.derive import ContactState, Derivation
    from fiv_cli.codegen.emit import Coefficients, TaylorStep
    from fiv_cli.codegen.graph import Graph, Node
    from fiv_cli.models.base import Model

FLOW, TANGENT, JACOBIAN = "flow", "tangent", "jacobian"

EVENT_ORDER = 1  # of series at an event or after an impact: a value and its rate
# A tangent has no offset, as a motion may have, that small terms are small against: with as many
# terms as the motion it would fall short of most steps by a little, and take two.
TANGENT_EXTRA = 2
JACOBIAN_ORDER = 1  # the first coefficient of a tangent is its rate: a column of the Jacobian

# Functions with a plateau, and the weight of their argument in what limits a step (see
# `within_plateau` of the kernel): exp has no pole and bears longer steps than tanh.
PLATEAU_WEIGHTS = {"tanh": 1.0, "exp": 0.25}


@dataclass(frozen=True)
class StateTable:
    """What the driver must know of one contact state.

    Attributes
    ----------
    kinds : 0 slip, 1 stick, 2 separation, per contact
    name : prefix of its functions
    guards : (kind, contact, place) of each switching function, in order
    has_angle : whether the sector's angle follows the switching functions
    n_arguments : how many arguments of saturating functions follow those, for step control
    impacts : contacts with an impact function, and one that carries tangents through it
    """

    kinds: tuple[int, ...]
    name: str
    guards: tuple[tuple[int, int, int], ...]
    has_angle: bool
    n_arguments: int
    impacts: tuple[int, ...]


@dataclass(frozen=True)
class Generated:
    """Text and tables of one system.

    Attributes
    ----------
    key : content key
    order : order of the Taylor steps
    state_names, parameter_names : entries of the vectors
    n_coefficients : length of the array ``c``
    n_followed : numbers that a step with tangents writes of the motion, at most
    states : index of the contact state -> its table
    smooth : per contact, whether the law has no border at zero slip
    sliding : kinds of the contacts where all slide, stops open
    bounces : per contact, whether an impact gives something back
    pieced : contacts whose law is given by pieces, the name of that law, and whether it has
        parameters of its own there
    n_stored : contacts whose stored energy is told: all or none
    zone : (start parameter, width parameter, contact) of the sector, or None
    texts : "flow", "tangent" and "jacobian"
    """

    key: str
    order: int
    state_names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    n_coefficients: int
    n_followed: int
    states: Mapping[int, StateTable]
    smooth: tuple[bool, ...]
    sliding: tuple[int, ...]
    bounces: tuple[bool, ...]
    pieced: tuple[tuple[int, str, bool], ...]
    n_stored: int
    zone: tuple[str, str, int] | None
    texts: Mapping[str, str]
    _engines: dict[str, ExecutionEngine] = field(default_factory=dict, compare=False, repr=False)

    @property
    def tangent_order(self) -> int:
        """Order of the series of tangents."""
        return self.order + TANGENT_EXTRA

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the generalised coordinates."""
        names = set(self.state_names)
        return tuple(name for name in self.state_names if f"{name}_dot" in names)

    def address(self, function: str, part: str = FLOW) -> int:
        """Address of a generated function, compiling its text if need be."""
        if part not in self._engines:
            self._engines[part] = load_text(self.texts[part])
        return int(self._engines[part].get_function_address(function))

    def is_compiled(self, part: str = FLOW) -> bool:
        """Whether the object code of this text is in the cache."""
        return cache.read(_object_name(self.texts[part])) is not None


def generate(setup: Setup, announce: Callable[[str], None] = lambda message: None) -> Generated:
    """Text and tables, from the cache or made now; `announce` says so when they are made."""
    key = text_key(setup)

    def made() -> bytes:
        announce(f"generating code for {setup.title} (once per user)")
        return _make(setup)

    stored = cache.kept(f"{key}.json", made)
    return _from_json(key, cache.frozen(json.loads(stored)))


def text_key(setup: Setup) -> str:
    """Hash of everything that decides generated text: source files, options, order, SymPy."""
    package = Path(__file__).parent
    sources = sorted(package.glob("*.py"))
    sources += [package.parent / "models" / "base.py"]
    laws = sorted((package.parent / "friction").glob("*.py"))  # they may be composed of one another
    files = [*sources, *_model_files(setup.model), *laws]
    outside = [one.origin.text for one in (setup.model, setup.law) if one.origin is not None]
    written = [dict(sorted(table.items())) for table in (setup.options, setup.structural)]
    settings = [*written, setup.order, list(setup.schedule.names)]
    return cache.content_key(
        [
            cache.source_of(*files),
            *outside,
            setup.model.name,
            setup.law.name,
            json.dumps(settings),
            str(NUMERICS_VERSION),
            version("sympy"),
        ]
    )


def _model_files(model: Model) -> list[Path]:
    """The model's file and those that models share; one from outside may be made of any."""
    from fiv_cli.models import all_models

    shared = (Path(__file__).parent.parent / "models").glob("*.py")
    if model.origin is not None:
        return sorted(shared)
    others = {m.equations.__module__ for m in all_models().values() if m.name != model.name}
    own = _source_file(model)
    kept = [file for file in shared if f"fiv_cli.models.{file.stem}" not in others]
    return sorted({own, *kept})


def _source_file(model: Model) -> Path:
    """The file that a model is written in.

    Raises
    ------
    UsageError
        there is none: it was typed.
    """
    import sys

    path = Path(getattr(sys.modules[model.equations.__module__], "__file__", None) or "")
    if not path.is_file():
        raise UsageError(
            f"model {model.name}: written in no file, whose text would tell its versions apart\n"
            "next: write it in FILE.py and import it from there"
        )
    return path


def _make(setup: Setup) -> bytes:
    from fiv_cli.codegen.derive import derive
    from fiv_cli.codegen.emit import (
        Coefficients,
        bernstein,
        constants,
        sums,
        sums_in_place,
        value_slope_bend,
    )

    derivation, order = derive(setup), setup.order
    coefficients = Coefficients()
    title = f"{setup.model.name}, {setup.law.name} friction, options {dict(setup.options)}"
    flow = [f"# {title}", "# state: " + ", ".join(derivation.state_names)]
    tangent = [f"# tangent flow of {title}"]
    jacobian = [f"# linearised flow of {title}"]
    length = 0
    for state in derivation.states.values():
        flow += _flow_text(derivation, state, order, coefficients)
        steps, written = _tangent_steps(derivation, state, order, coefficients)
        tangent += steps + _event_tangents(derivation, state, coefficients)
        jacobian += _jacobian_text(derivation, state, coefficients)
        length = max(length, written)
    flow += sums("state", len(derivation.state_names), order)
    tangent += sums_in_place("moved", len(derivation.state_names), order + TANGENT_EXTRA)
    flow += value_slope_bend("value_slope_bend", order)
    flow += bernstein("bernstein", order)
    flow += constants("coefficients", coefficients.nodes, derivation.parameter_names)
    texts = {FLOW: flow, TANGENT: tangent, JACOBIAN: jacobian}
    content = {
        "order": order,
        "state_names": derivation.state_names,
        "parameter_names": derivation.parameter_names,
        "n_coefficients": len(coefficients.nodes),
        "n_followed": length,
        "states": {index: _table(state) for index, state in derivation.states.items()},
        "smooth": derivation.smooth,
        "sliding": derivation.sliding,
        "bounces": derivation.bounces,
        "pieced": derivation.pieced,
        "n_stored": len(next(iter(derivation.states.values())).stored),
        "zone": derivation.zone,
        "texts": {part: "\n".join(lines) + "\n" for part, lines in texts.items()},
    }
    return json.dumps(content).encode()


def _table(state: ContactState) -> dict[str, object]:
    return {
        "kinds": state.kinds,
        "name": state.name,
        "guards": [(guard.kind, guard.contact, guard.place) for guard in state.guards],
        "has_angle": state.angle is not None,
        "n_arguments": len(_saturating(state)),
        "impacts": sorted(state.impacts),
    }


def _saturating(state: ContactState) -> list[tuple[str, Node]]:
    """Functions, with their arguments, whose series says nothing of what lies off their plateau."""
    from fiv_cli.codegen.graph import reachable

    nodes = [node for node in reachable(state.rates) if node.op in PLATEAU_WEIGHTS]
    return [(node.op, node.args[0]) for node in nodes]


def _flow_text(
    derivation: Derivation, state: ContactState, order: int, coefficients: Coefficients
) -> list[str]:
    from fiv_cli.codegen.emit import TaylorStep, along_series, pointwise

    graph, switching = derivation.graph, _switching(state)
    watched = _watched(graph, state)
    step = TaylorStep(graph, state.values, state.rates, watched, order, coefficients)
    lines = step.text(f"{state.name}_taylor", f"series of state and switching, {state.name}")
    contacts = [node for outputs in state.contacts for node in outputs]
    outputs = [
        *state.values, *state.rates, *switching, *contacts, *state.stored, *state.energies,
    ]  # fmt: skip
    name = f"{state.name}_field"
    lines += pointwise(graph, name, f"{state.name}: rates and forces", outputs, coefficients)
    outputs = [*state.values, *switching]
    name = f"{state.name}_guards"
    lines += pointwise(graph, name, f"{state.name}: switching functions", outputs, coefficients)
    outputs = [*state.values, *state.rates, *state.energies[OTHER_POWER:]]
    name = f"{state.name}_measured"
    lines += along_series(graph, name, "what is measured", outputs, order, coefficients)
    powers, name = state.energies[OTHER_POWER:], f"{state.name}_powers"
    lines += along_series(graph, name, "powers alone", powers, order, coefficients, "nodes")
    for contact in state.impacts:
        values = _after_impact(state, contact)
        name = f"{state.name}_impact_{contact}"
        lines += pointwise(graph, name, "state after a plastic impact", values, coefficients)
    return lines


def _switching(state: ContactState) -> list[Node]:
    """The switching functions, and the angle of a sector."""
    return [guard.node for guard in state.guards] + ([] if state.angle is None else [state.angle])


def _watched(graph: Graph, state: ContactState) -> list[Node]:
    """What a step is watched by: `_switching`, and arguments of saturating functions."""
    arguments = [
        graph.mul(graph.number(PLATEAU_WEIGHTS[op]), argument)
        for op, argument in _saturating(state)
    ]
    return [*_switching(state), *arguments]


def _tangent_steps(
    derivation: Derivation, state: ContactState, order: int, coefficients: Coefficients
) -> tuple[list[str], int]:
    """Steps of the motion and of its tangents beside it; how many numbers the first one writes."""
    from fiv_cli.codegen.emit import FollowedStep, TangentStep

    graph, name = derivation.graph, state.name
    motion = FollowedStep(
        graph, state.values, state.rates, _watched(graph, state), order, TANGENT_EXTRA,
        coefficients,
    )  # fmt: skip
    tangents = TangentStep(graph, motion).text(f"{name}_tangent", f"series of tangents, {name}")
    lines = motion.text(f"{name}_followed", f"series of the motion for its tangents, {name}")
    return lines + tangents, motion.length


def _event_tangents(
    derivation: Derivation, state: ContactState, coefficients: Coefficients
) -> list[str]:
    graph, name = derivation.graph, state.name
    step = _step_with_tangents(graph, state, _switching(state), EVENT_ORDER, coefficients)
    lines = step.text(f"{name}_switching", f"switching, with a tangent vector, {name}")
    for contact in sorted(state.impacts):
        lines += _impact_tangent_text(derivation, state, contact, coefficients)
    return lines


def _jacobian_text(
    derivation: Derivation, state: ContactState, coefficients: Coefficients
) -> list[str]:
    """What an equilibrium asks of the tangents, a hundredth of their text."""
    step = _step_with_tangents(derivation.graph, state, [], JACOBIAN_ORDER, coefficients)
    return step.text(f"{state.name}_jacobian", f"rates of state and tangent, {state.name}")


def _impact_tangent_text(
    derivation: Derivation, state: ContactState, contact: int, coefficients: Coefficients
) -> list[str]:
    """State after an impact and its tangent, each with its rate along the flow before it."""
    after = _after_impact(state, contact)
    step = _step_with_tangents(derivation.graph, state, after, EVENT_ORDER, coefficients)
    name = f"{state.name}_impact_tangent_{contact}"
    return step.text(name, "state after a plastic impact, with a tangent vector")


def _after_impact(state: ContactState, contact: int) -> list[Node]:
    """Every entry of the state after an impact on a contact."""
    return [state.impacts[contact].get(i, node) for i, node in enumerate(state.values)]


def _step_with_tangents(
    graph: Graph, state: ContactState, watched: list[Node], order: int, coefficients: Coefficients
) -> TaylorStep:
    """A Taylor step of the state, what is watched along it, and a tangent of both."""
    from fiv_cli.codegen.emit import TaylorStep

    return TaylorStep(
        graph,
        [*state.values, *map(graph.tangent, state.values)],
        [*state.rates, *map(graph.tangent, state.rates)],
        [*watched, *map(graph.tangent, watched)],
        order,
        coefficients,
    )


def _from_json(key: str, content: dict[str, Any]) -> Generated:
    states = {int(i): StateTable(**table) for i, table in content.pop("states").items()}
    return Generated(key=key, states=states, **content)


def _object_name(text: str) -> str:
    from fiv_cli.codegen import lower

    own = Path(lower.__file__)
    source = cache.source_of(own.with_name("assembly.py"), own)
    return cache.content_key([text, source, lower.machine_description()]) + ".o"


def load_text(text: str) -> ExecutionEngine:
    """Execution engine with the functions of `text`, compiled unless the cache has the object."""
    from fiv_cli.codegen import lower

    return lower.load_object(cache.kept(_object_name(text), lambda: lower.compile_text(text)))
