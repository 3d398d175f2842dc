"""From the coordinates of a point to its key, its start and its `Request`.

A `Template` holds what all points of one analysis share; it travels to the workers once per
task, and the points themselves are only tuples of axis values.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import islice, product
from typing import Any

import numpy as np

from fiv_cli.analyses.base import (
    STEADY,
    Batch,
    Request,
    Schedule,
    Setup,
    SolverSettings,
    Start,
    as_asked,
    broken,
    value_of,
)
from fiv_cli.case.case import StartSpec
from fiv_cli.friction import get_law
from fiv_cli.friction.base import Law
from fiv_cli.models import get_model
from fiv_cli.models.base import Model, Requirement
from fiv_cli.models.origin import Origin

Values = tuple[Any, ...]


@dataclass(frozen=True)
class StartEntry:
    """One label of the dim ``initial``.

    Attributes
    ----------
    label : the coordinate
    spec : the ``[[initial]]`` table it comes from
    number : which of the starts of `spec` it is
    origin : for "continue", the entry that starts the chain, or the chain at whose end it begins
    """

    label: str
    spec: StartSpec
    number: int = 0
    origin: StartEntry | None = None

    @property
    def row(self) -> Mapping[str, float]:
        """The start, where `spec` is a table."""
        return self.spec.rows[self.number] if self.spec.rows else {}

    @cached_property
    def identity(self) -> str:
        """Everything that decides the start, as text; numbers keep every bit."""
        spec = self.spec
        own = [
            spec.kind,
            *(sorted((n, float(v).hex()) for n, v in spec.offset.items())),
            *(sorted((n, _exact(v)) for n, v in spec.state.items())),
            *(sorted((n, low.hex(), high.hex()) for n, (low, high) in spec.box.items())),
            (spec.seed, self.number) if spec.kind == "random" else (),
            (spec.along, spec.direction, spec.on_loss),
            *([spec.steps] if spec.steps == "grid" else ()),
            *(sorted((n, _exact(v)) for n, v in self.row.items())),
        ]
        origin = "" if self.origin is None else self.origin.identity
        return f"{own}{origin}"


@dataclass(frozen=True)
class Template:
    """What all points of one analysis share.

    Attributes
    ----------
    model, law, options : names, and every option; what an axis varies is overridden by it
    parameters : law -> values that no axis varies, SI
    names : law -> names of all parameters of the model and the law
    followers : (parameter, leader): parameters that take another one's value unless given
    axes : (name, kind) of every axis, in order
    entries : the starts; a single None where the analysis has none
    linear : no motion is followed
    base : digest of everything that decides a point but its axis values and its start
    schedule : parameters that vary in time
    own : the texts of a model and laws that are not in the box
    """

    model: str
    law: str
    options: Mapping[str, str]
    parameters: Mapping[str, Mapping[str, float]]
    names: Mapping[str, tuple[str, ...]]
    followers: tuple[tuple[str, str], ...]
    axes: tuple[tuple[str, str], ...]
    entries: tuple[StartEntry | None, ...]
    analysis: str
    settings: Mapping[str, Any]
    solver: SolverSettings
    linear: bool
    base: bytes
    schedule: Schedule = STEADY
    own: tuple[Origin, ...] = ()

    @cached_property
    def axes_by_kind(self) -> Mapping[str, Sequence[tuple[str, int]]]:
        """Kind -> (name, place among the values of a point) of its axes."""
        kinds = {kind for _, kind in self.axes}
        numbered = [(name, kind, place) for place, (name, kind) in enumerate(self.axes)]
        return {kind: [(n, p) for n, k, p in numbered if k == kind] for kind in kinds}

    @cached_property
    def ordered(self) -> Mapping[str, tuple[dict[str, float], list[tuple[str, str]], set[str]]]:
        """Law -> its parameters in order, zero where an axis says more, (follower, leader) of those
        that follow one, and what another law alone has."""
        axes = [name for name, _ in self.axes_by_kind.get("parameter", ())]
        found = {}
        for law, names in self.names.items():
            given, followers = {**self.parameters[law], **dict.fromkeys(axes, 0.0)}, []
            for follower, leader in self.followers:
                if follower not in given and leader in given:
                    followers.append((follower, leader))
                    given[follower] = 0.0
            ordered = {name: given[name] for name in names if name in given} | given
            found[law] = ordered, followers, given.keys() - set(names)
        return found


def parameters_at(template: Template, values: Values) -> dict[str, float]:
    """Every parameter of the model and the law in force at a point, SI."""
    known, followers, others = template.ordered[law_at(template, values)]
    given = {**known, **_of_kind(template, values, "parameter")}
    for follower, leader in followers:
        given[follower] = given[leader]
    for name in others:
        del given[name]
    return given


def law_at(template: Template, values: Values) -> str:
    """Name of the friction law at a point."""
    axes = template.axes_by_kind.get("law")
    law: str = values[axes[0][1]] if axes else template.law
    return law


def exclusion(request: Request, linear: bool) -> Requirement | None:
    """What the parameters of a point do not meet, so that it is not computed; None when it is.

    `linear` : no motion is followed
    """
    setup, parameters = request.setup, request.parameters
    if not setup.schedule.curves:
        return broken(setup.model, setup.law, parameters, linear)
    varied = ({**parameters, **setup.schedule.values(t)} for t in setup.schedule.instants)
    unmet = (broken(setup.model, setup.law, there, linear) for there in varied)
    return next(filter(None, unmet), None)


def request_at(
    template: Template,
    values: Values,
    start: Start | None,
    batch: Batch | None = None,
    setup: Setup | None = None,
) -> Request:
    """The run of a point from `start`, one of `batch`; `setup`: that of all points, if one is."""
    parameters = parameters_at(template, values)
    setup = setup or setup_at(template, values, parameters)
    settings, solver = template.settings, template.solver
    return Request(setup, parameters, template.analysis, settings, solver, start, batch)


def setup_at(template: Template, values: Values, parameters: Mapping[str, float]) -> Setup:
    """The setup of a point."""
    options = {**template.options, **_of_kind(template, values, "option")}
    law = get_law(law_at(template, values))
    structural = tuple((name, parameters[name]) for name in law.structural)
    model = as_asked(get_model(template.model), template.settings)
    rtol, schedule = template.solver.rtol, template.schedule
    return _setup(model, law, tuple(options.items()), structural, rtol, schedule)


def shared_setup(template: Template, values: Values) -> Setup | None:
    """The setup of a point, if it is that of all points."""
    deciding = {"option", "law"}
    if get_law(template.law).structural:
        deciding.add("parameter")
    if deciding & template.axes_by_kind.keys():
        return None
    return setup_at(template, values, parameters_at(template, values))


@lru_cache(maxsize=256)
def _setup(
    model: Model,
    law: Law,
    options: tuple[tuple[str, str], ...],
    structural: tuple[tuple[str, float], ...],
    rtol: float,
    schedule: Schedule,
) -> Setup:
    """The setup of all points with these; most sweeps have one."""
    return Setup.of(model, law, dict(options), dict(structural), rtol, schedule)


def place_digest(template: Template, values: Values) -> bytes:
    """sha256 of everything that decides a point but its start."""
    pieces = [
        packed(template, kind, value)
        for (_, kind), value in zip(template.axes, values, strict=True)
    ]
    return hashlib.sha256(template.base + b"".join(pieces)).digest()


def place_digests(template: Template, dims: Sequence[Sequence[Values]]) -> Iterator[bytes]:
    """`place_digest` of all points of a grid in C order, from the values along its dims."""
    kinds = iter([kind for _, kind in template.axes])
    pieces_of_dims = []
    for dim in dims:
        own = list(islice(kinds, len(dim[0])))
        pieces_of_dims.append(
            [b"".join(map(partial(packed, template), own, values)) for values in dim]
        )
    bases = (b"".join((template.base, *pieces)) for pieces in product(*pieces_of_dims))
    return (hashlib.sha256(base).digest() for base in bases)


def keys_at(places: Sequence[bytes], entry: StartEntry | None) -> Iterator[bytes]:
    """`point_key` of points of these `place_digests` that start on their own."""
    own = b"" if entry is None else entry.identity.encode()
    return (hashlib.sha256(place + own).digest() for place in places)


def keys_along(points: Iterable[tuple[bytes, StartEntry | None]]) -> bytes:
    """`point_key` of the points of a chain, (place, start) of each, one after the other."""
    keys = [b""]
    for place, entry in points:
        own = b"" if entry is None else entry.identity.encode()
        keys.append(hashlib.sha256(place + own + keys[-1]).digest())
    return b"".join(keys)


def point_key(
    template: Template, values: Values, entry: StartEntry | None, previous: bytes = b""
) -> bytes:
    """sha256 of everything that decides a point; 32 bytes.

    `previous` is the key of the neighbour that a continued point starts from: a point of a chain
    depends on all before it.
    """
    own = b"" if entry is None else entry.identity.encode()
    return hashlib.sha256(place_digest(template, values) + own + previous).digest()


def resolve_start(template: Template, values: Values, entry: StartEntry) -> Start:
    """The start of a point that does not continue from a neighbour."""
    origin = entry
    while origin.origin is not None:
        origin = origin.origin
    kind = "equilibrium" if origin.spec.kind == "equilibrium" else "state"
    own = _START_VALUES[origin.spec.kind](template, values, origin)
    varied = start_axes(template, values)
    state = origin.spec.state.items()
    named = {n: p for n, p in state if isinstance(p, str) and n not in varied}
    return Start(entry.label, kind, {**own, **varied}, named=named)


def is_shared(template: Template, entry: StartEntry) -> bool:
    """Whether a start is the same at all points."""
    spec = entry.spec
    follows = spec.kind in ("random", "continue") or any(
        isinstance(value, str) for value in spec.state.values()
    )
    return not follows and not template.axes_by_kind.get("start")


def start_axes(template: Template, values: Values) -> dict[str, float]:
    """Components of the start that are axes: state -> value."""
    of_kind = _of_kind(template, values, "start")
    return {name.removeprefix("initial."): value for name, value in of_kind.items()}


def continued_start(entry: StartEntry, carried: Mapping[str, Any]) -> Start:
    """The start of a point that continues from its neighbour."""
    begun = Start(entry.label, "continue", dict(entry.spec.offset), carried)
    from_rest, literal = entry.spec.on_loss == "go-on", entry.spec.steps == "grid"
    return replace(begun, from_rest=from_rest, literal=literal)


def _offset(template: Template, values: Values, entry: StartEntry) -> dict[str, float]:
    return dict(entry.spec.offset)


def _state(template: Template, values: Values, entry: StartEntry) -> dict[str, float]:
    state = entry.spec.state
    if not any(isinstance(value, str) for value in state.values()):
        return {name: float(value) for name, value in state.items()}
    parameters = parameters_at(template, values)
    return {n: value_of(v, parameters) if isinstance(v, str) else v for n, v in state.items()}


def _random(template: Template, values: Values, entry: StartEntry) -> dict[str, float]:
    """Drawn from the box; seeded by the model and its parameters, which are what the start is of.

    Never by the position in the grid, nor by how the point is asked: the same starts with more
    time, another tolerance or another analysis.
    """
    parameters = sorted((n, float(v).hex()) for n, v in parameters_at(template, values).items())
    seed = hashlib.sha256(f"{template.model}{parameters}{entry.identity}".encode())
    generator = np.random.Generator(np.random.PCG64(int.from_bytes(seed.digest(), "little")))
    return {
        name: float(generator.uniform(low, high))
        for name, (low, high) in sorted(entry.spec.box.items())
    }


def _of_table(template: Template, values: Values, entry: StartEntry) -> dict[str, float]:
    return dict(entry.row)


_START_VALUES = {"equilibrium": _offset, "state": _state, "random": _random, "table": _of_table}


def expand_starts(specs: Sequence[StartSpec]) -> tuple[StartEntry, ...]:
    """The labels of the dim ``initial``: one per start, `count` of random ones or a table."""
    plain = [entry for spec in specs if spec.kind != "continue" for entry in _expanded(spec)]
    origins = {entry.label: entry for entry in reversed(plain)}
    origins |= {entry.spec.label: entry for entry in reversed(plain)}
    by_spec = {spec.label: [e for e in plain if e.spec is spec] for spec in specs}
    chains = {spec.label: spec for spec in specs if spec.kind == "continue"}

    def begun(label: str) -> StartEntry:
        if label not in origins:
            spec = chains[label]
            origins[label] = StartEntry(label, spec, origin=begun(spec.from_label))
        return origins[label]

    return tuple(e for spec in specs for e in by_spec.get(spec.label) or [begun(spec.label)])


def _expanded(spec: StartSpec) -> list[StartEntry]:
    return [StartEntry(label, spec, number=i) for i, label in enumerate(spec.labels)]


def _of_kind(template: Template, values: Values, kind: str) -> dict[str, Any]:
    return {name: values[place] for name, place in template.axes_by_kind.get(kind, ())}


def packed(template: Template, kind: str, value: Any) -> bytes:
    """Everything that a value of an axis of this kind decides."""
    if kind == "law":  # with what no axis says of it: another law has other parameters
        fixed = sorted((n, float(v).hex()) for n, v in template.parameters[value].items())
        law = get_law(value)
        text = [law.origin.digest] if law.origin else []
        value = " ".join([value, str(law.numerics_version), *text, f"{fixed}"])
    if isinstance(value, str):
        return b"s" + value.encode() + b"\0"
    return b"d" + struct.pack("<d", value + 0.0)  # a negative zero is a zero


def _exact(value: float | str) -> str:
    return value if isinstance(value, str) else (float(value) + 0.0).hex()
