"""What a case may add to a model: forces, a moving base, parameters that vary harmonically.

    force_x   F_x + A_x cos(omega_x t + phase_x) acts on the coordinate x
    base      what holds the model moves by A_base cos(omega_base t + phase_base): its springs and
              dampers feel coordinates relative to it
    v(t)      the parameter v is v + A_v cos(omega_v t + phase_v)

Each is a term of a name, ``belt-1dof + force_x + v(t)``: an excited model is another one, so that
of a model without excitation nothing changes. ``omega_v = omega`` is a term too: a parameter that
takes the value of another. Forces divide by the mass matrix, that of the kinetic energy.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, wraps
from itertools import product
from math import cos, pi
from typing import TYPE_CHECKING

from fiv_cli.errors import UsageError
from fiv_cli.models.base import (
    MOST_RATIO,
    Equations,
    Forcing,
    Model,
    Options,
    Parameter,
    Requirement,
    common_frequency,
)

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols

BETWEEN = " + "
BASE = "base"
LOOKS = 32  # at a turn of what varies, whether requirements hold
UNITS_OF_FORCES = {"m": "N", "rad": "N m"}

NAMES = {
    "mean": "{}",
    "constant": "F_{}",
    "amplitude": "A_{}",
    "omega": "omega_{}",
    "phase": "phase_{}",
}
"""Key of a table of a case -> the parameter that it gives."""

_TERM = r"(?P<force>force_\w+)|base|(?P<varied>\w+)\(t\)(?: in (?P<unit>.+))?"


@dataclass(frozen=True)
class Term:
    """One excitation.

    Attributes
    ----------
    kind : "force", "base" or "parameter"
    of : the coordinate, "base", or the parameter
    unit : of a parameter that is the law's; the model knows that of its own
    """

    kind: str
    of: str
    unit: str = ""

    @property
    def text(self) -> str:
        """How it stands in the name of a model."""
        unit = f" in {self.unit}" if self.unit else ""
        return {"force": f"force_{self.of}", "base": BASE}.get(self.kind, f"{self.of}(t){unit}")

    def named(self, key: str) -> str:
        """The parameter that a key of the case gives, ``amplitude`` -> ``A_x``."""
        return NAMES[key].format(self.of)


def terms_of(model: str) -> tuple[str, list[Term], dict[str, str]]:
    """Of the name of an excited model: the model's own, its excitations, and what follows what."""
    plain, *texts = model.split(BETWEEN)
    leaders = dict(text.split(" = ") for text in texts if " = " in text)
    return plain, [_term(text) for text in texts if " = " not in text], leaders


def _term(text: str) -> Term:
    found = re.fullmatch(_TERM, text)
    if found is None:
        raise UsageError(
            f"{text!r} is no excitation of a model\n"
            "next: write force_COORDINATE, base or PARAMETER(t) after a +"
        )
    if found["varied"]:
        return Term("parameter", found["varied"], found["unit"] or "")
    return Term("force", text.removeprefix("force_")) if found["force"] else Term(BASE, BASE)


def following(model: Model, leaders: Mapping[str, str]) -> Model:
    """`model` with parameters that take the value of another: parameter -> that one."""
    texts = (f"{name} = {leader}" for name, leader in leaders.items())
    return excited(model, BETWEEN.join([model.name, *texts])) if leaders else model


@cache
def excited(model: Model, name: str) -> Model:
    """`model` under the excitations, and with the followers, that `name` tells of."""
    _, terms, leaders = terms_of(name)
    added: list[Parameter] = []
    for term in terms:
        _refuse_nothing(model, term)
        added += _parameters(model, term, added)
    _refuse_two_of_one_name(model, added)
    every = [*model.parameters, *added]
    own = {n: leader for n, leader in leaders.items() if n in {p.name for p in every}}
    table = _following(every, own)
    varied = tuple(term.of for term in terms if term.kind == "parameter")
    loads = _of_role(model, "preload")
    alone = len(terms) == 1 and not model.forcings
    forcings = [_forcing(model, term, alone) for term in terms]
    return replace(
        model,
        name=name,
        title=f"{model.title}, excited" if terms else model.title,
        parameters=tuple(table),
        law_leaders={n: leader for n, leader in leaders.items() if n not in own},
        equations=_equations(model, terms),
        constant_load=model.constant_load and not loads & set(varied),
        forcings=(*model.forcings, *forcings),
        requirements=(*model.requirements, *_requirements(model, terms, forcings)),
        varied=varied,
        powers={term.text: _power_of(term) for term in terms if term.kind != "parameter"},
    )


def _refuse_nothing(model: Model, term: Term) -> None:
    """UsageError where the model has nothing of the kind."""
    known = {
        "force": {s.name for s in model.states(model.default_options())},
        "base": {BASE} if model.base else set(),
        "parameter": {p.name for p in model.parameters} | {term.of if term.unit else ""},
    }
    lumped = term.kind == "parameter" or model.derived is None
    if term.of not in known[term.kind] or not lumped:
        raise UsageError(
            f"{term.text!r} is no excitation of {model.name}\n"
            f"next: fiv models {model.name}; of a parameter of the law, NAME(t) in UNIT"
        )


def _refuse_two_of_one_name(model: Model, added: Sequence[Parameter]) -> None:
    names = [p.name for p in (*model.parameters, *added)]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise UsageError(
            f"{model.name} and its excitation have parameters of one name: {', '.join(twice)}\n"
            "next: rename that of the model, or excite it once"
        )


# --- tables ---------------------------------------------------------------------------------------
def _parameters(model: Model, term: Term, earlier: Sequence[Parameter]) -> Iterator[Parameter]:
    """Those of an excitation; its frequency is that of the first one, or the model's own."""
    own = (*earlier, *model.parameters)
    known = [p.name for p in own if p.role == "frequency" and p.unit == "rad s-1"]
    of, unit, what = term.of, _unit(model, term), _meaning(term)
    if term.kind == "force":
        yield Parameter(f"F_{of}", f"F_{{{of}}}", unit, 0.0, f"constant part of the {what}")
    yield Parameter(
        f"A_{of}", f"A_{{{of}}}", unit, 0.0, f"amplitude of the {what}", "", 0.0, role="amplitude"
    )
    leader = next(iter(known), None)
    yield Parameter(
        f"omega_{of}", rf"\omega_{{{of}}}", "rad s-1", None if leader else 1.0,
        f"frequency of the {what}", "", 0.0, exclusive=True, default_from=leader, role="frequency",
    )  # fmt: skip
    yield Parameter(f"phase_{of}", rf"\varphi_{{{of}}}", "rad", 0.0, f"phase of the {what}")


def _unit(model: Model, term: Term) -> str:
    """The unit of its amplitude."""
    if term.kind == "force":
        states = {s.name: s.unit for s in model.states(model.default_options())}
        return UNITS_OF_FORCES.get(states.get(term.of, ""), "1")
    own = {p.name: p.unit for p in model.parameters}
    return "m" if term.kind == "base" else own.get(term.of, term.unit or "1")


def _meaning(term: Term) -> str:
    said = {"force": f"force on {term.of}", "base": "motion of the base"}
    return said.get(term.kind, f"variation of {term.of}")


def _power_of(term: Term) -> str:
    """What its mean power is called, see `Model.powers`."""
    return "the base that moves" if term.kind == "base" else f"the external force along {term.of}"


def _following(table: Sequence[Parameter], leaders: Mapping[str, str]) -> list[Parameter]:
    """A table with what follows another; that one is to be what each of them may be."""
    found = {p.name: p for p in table}
    for name, leader in leaders.items():
        found[leader] = found[leader].within(found[name])
        found[name] = replace(found[name], default=None, default_from=leader)
    return [*found.values()]


def _forcing(model: Model, term: Term, alone: bool) -> Forcing:
    of, fast = term.of, None
    if alone and model.contacts == 1 and (term.kind == "force" or of in _of_role(model, "speed")):
        fast = _fast_velocity(model, term)
    return Forcing(f"A_{of}", lambda p: p[f"omega_{of}"], _meaning(term), fast)


def _of_role(model: Model, role: str) -> set[str]:
    """The parameters of a role, and what takes the value of one."""
    names = {p.name for p in model.parameters if p.role == role}
    return names | {p.name for p in model.parameters if p.default_from in names}


# --- what parameters must be to one another -------------------------------------------------------
def _requirements(
    model: Model, terms: Sequence[Term], forcings: Sequence[Forcing]
) -> Iterator[Requirement]:
    every = (*model.forcings, *forcings)
    if len(every) > 1:
        yield common_period(every, model.derived is not None)
    for term in terms:
        for forcing in model.forcings:
            if term.of in frequency_of(forcing):
                yield _one_of_two(forcing, term)


def common_period(forcings: Sequence[Forcing], one_only: bool) -> Requirement:
    """`one_only`: where their frequencies follow from more than parameters."""
    amplitudes = [forcing.amplitude for forcing in forcings]
    read = [] if one_only else [name for forcing in forcings for name in frequency_of(forcing)]

    def holds(p: Mapping[str, float]) -> bool:
        on = sum(p[name] != 0.0 for name in amplitudes)
        return on < 2 or (not one_only and common_frequency(forcings, p) is not None)

    return Requirement(
        tuple(dict.fromkeys([*amplitudes, *read])),
        holds,
        f"frequencies in a ratio of whole numbers up to {MOST_RATIO}, or one amplitude only",
        "the excitations have no common period",
        "no_common_period",
        in_motion=True,
    )


def _one_of_two(forcing: Forcing, term: Term) -> Requirement:
    own, theirs = f"A_{term.of}", forcing.amplitude
    return Requirement(
        (own, theirs),
        lambda p: p[own] == 0.0 or p[theirs] == 0.0,
        f"{own} = 0 or {theirs} = 0",
        f"the {forcing.meaning} has a phase that depends on {term.of}, which varies",
        "no_common_period",
    )


def frequency_of(forcing: Forcing) -> tuple[str, ...]:
    """The parameters that the frequency of an excitation depends on."""
    asked = _Asked()
    forcing.frequency(asked)
    return tuple(asked)


class _Asked(dict[str, float]):
    """Parameters that are all 1; it holds those that were asked for."""

    def __missing__(self, name: str) -> float:
        self[name] = 1.0
        return 1.0


def at_every_phase(
    requirements: Sequence[Requirement], varied: Sequence[str], table: Mapping[str, Parameter]
) -> list[Requirement]:
    """The requirements while parameters vary harmonically; these stay in their range."""
    bounds = [_in_range(table[name]) for name in varied if name in table]
    return bounds + [_throughout(one, varied) for one in requirements]


def _in_range(parameter: Parameter) -> Requirement:
    name, amplitude = parameter.name, f"A_{parameter.name}"

    def holds(p: Mapping[str, float]) -> bool:
        low, high = p[name] - p[amplitude], p[name] + p[amplitude]
        above = low > parameter.minimum if parameter.exclusive else low >= parameter.minimum
        return p[amplitude] == 0.0 or (above and high <= parameter.maximum)

    return Requirement(
        (name, amplitude), holds, f"{name} at every phase {parameter.allowed}",
        f"{name} leaves its range while it varies", "leaves_range",
    )  # fmt: skip


def _throughout(requirement: Requirement, varied: Sequence[str]) -> Requirement:
    names = [name for name in varied if name in requirement.reads]

    def holds(p: Mapping[str, float]) -> bool:
        ends = (
            {name: p[name] + turn * p[f"A_{name}"] for name, turn in zip(names, turns, strict=True)}
            for turns in _turns(names, p)
        )
        return all(requirement.holds({**p, **end}) for end in ends)

    read = [NAMES[key].format(name) for name in names for key in ("amplitude", "omega", "phase")]
    reads = (*requirement.reads, *read)
    return replace(requirement, reads=reads, holds=holds) if names else requirement


def _turns(names: Sequence[str], p: Mapping[str, float]) -> Iterable[tuple[float, ...]]:
    """What the cosines of some parameters may be at once; of one frequency they go together."""
    phases = [p[f"phase_{name}"] for name in names]
    if len({p[f"omega_{name}"] for name in names}) > 1:
        return product((-1.0, 1.0), repeat=len(names))
    ends = [end - phase for phase in phases for end in (0.0, pi)]
    angles = [*ends, *(2 * pi * turn / LOOKS for turn in range(LOOKS))]
    return (tuple(cos(angle + phase) for phase in phases) for angle in angles)


# --- equations ------------------------------------------------------------------------------------
def _equations(model: Model, terms: Sequence[Term]) -> Callable[[Symbols, Options], Equations]:
    varied = [term.of for term in terms if term.kind == "parameter"]
    own = {p.name for p in model.parameters}

    @wraps(model.equations)
    def equations(symbols: Symbols, options: Options) -> Equations:
        moving = symbols.varying(varied)
        found = model.equations(moving, options)
        if any(term.kind == BASE for term in terms):
            found = _on_moving_base(found, symbols, model.base)
        for term in terms:
            if term.kind == "force" and term.of in found.accelerations:
                found = _forced(found, symbols, term.of)
        of_law = {name: moving.parameter(name) for name in varied if name not in own}
        return replace(found, law_parameters=of_law | dict(found.law_parameters))

    return equations


def _on_moving_base(found: Equations, symbols: Symbols, carried: Sequence[str]) -> Equations:
    """Springs and dampers feel the carried coordinates relative to the base, contacts do not."""
    import sympy

    moved = symbols.swing(BASE)
    rate = sympy.diff(moved, symbols.time)
    relative = {symbols.coordinate(q): symbols.coordinate(q) - moved for q in carried}
    relative |= {symbols.velocity(q): symbols.velocity(q) - rate for q in carried}
    accelerations = {
        q: sympy.sympify(a).subs(relative, simultaneous=True)
        for q, a in found.accelerations.items()
    }
    apart = {symbols.closed(i): 0 for i in range(len(found.contacts))}
    structure = sympy.sympify(found.potential_energy).subs(apart)
    felt = structure.subs(relative, simultaneous=True)
    free = _without_contact(found, symbols)
    masses = _masses(found, symbols)
    names = list(accelerations)
    rows = [names.index(q) for q in carried]
    held = masses[rows, :] * sympy.Matrix([accelerations[q].subs(free) for q in names])
    return replace(
        found,
        accelerations=accelerations,
        potential_energy=found.potential_energy - structure + felt,
        powers={**found.powers, BASE: rate * sum(held)},
    )


def _without_contact(found: Equations, symbols: Symbols) -> dict[Expr, int]:
    contacts = range(len(found.contacts))
    tangential = {symbols.tangential_force(i): 0 for i in contacts}
    return tangential | {symbols.normal_force(i): 0 for i in contacts}


def _forced(found: Equations, symbols: Symbols, of: str) -> Equations:
    """The equations with an external force on a coordinate."""
    force = symbols.parameter(f"F_{of}") + symbols.swing(of)
    gained = _mobility(found, symbols, of)
    return replace(
        found,
        accelerations={q: a + force * gained[q] for q, a in found.accelerations.items()},
        powers={**found.powers, f"force_{of}": force * symbols.velocity(of)},
    )


def _masses(found: Equations, symbols: Symbols) -> Expr:
    """The mass matrix."""
    import sympy

    velocities = [symbols.velocity(name) for name in found.accelerations]
    return sympy.hessian(sympy.expand(found.kinetic_energy), velocities)


def _mobility(found: Equations, symbols: Symbols, of: str) -> dict[str, Expr]:
    """The accelerations under a unit force on a coordinate: a column of the inverse mass matrix."""
    import sympy

    names = list(found.accelerations)
    unit = sympy.Matrix([int(name == of) for name in names])
    column = _masses(found, symbols).LUsolve(unit)
    return dict(zip(names, column, strict=True))


def _fast_velocity(model: Model, term: Term) -> Callable[[Mapping[str, float]], float]:
    """Amplitude of the slip velocity where a fast force moves a free mass, or the drive itself."""

    def fast_velocity(p: Mapping[str, float]) -> float:
        names, share = _share_of_slip(model, term)
        inertia = p[f"omega_{term.of}"] if term.kind == "force" else 1.0
        return abs(float(share(*(p[name] for name in names)))) * p[f"A_{term.of}"] / inertia

    return fast_velocity


@cache
def _share_of_slip(model: Model, term: Term) -> tuple[list[str], Callable[..., float]]:
    """What a unit of the fast force, or of the drive's speed, adds to the slip's rate, or to it."""
    import sympy

    from fiv_cli.models.symbols import Symbols

    symbols = Symbols()
    found = model.equations(symbols, model.default_options())
    slip = found.contacts[0].slip_velocity
    if term.kind == "force":
        gained = _mobility(found, symbols, term.of)
        share = sum(sympy.diff(slip, symbols.velocity(q)) * a for q, a in gained.items())
    else:
        share = sympy.diff(slip, symbols.parameter(term.of))
    free = sorted(sympy.sympify(share).free_symbols, key=str)
    return [str(s).removeprefix("p.") for s in free], sympy.lambdify(free, share, "math")
