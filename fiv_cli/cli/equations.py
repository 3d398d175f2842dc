"""The equations of a model as text, printed from the very expressions that are computed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from textwrap import wrap
from typing import Any

from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Contact, Model


def equation_lines(model: Model) -> list[str]:
    """Accelerations, contacts and energies of `model` under its default options."""
    from fiv_cli.models.symbols import Symbols

    options = model.default_options()
    symbols = Symbols()
    equations = model.mechanics(symbols, options)
    printer = _printer(model)
    lines = ["Equations (F_T: friction force on the body, F_N: normal force)", ""]
    for name, acceleration in equations.accelerations.items():
        lines.append(f"  {name}'' = {printer(acceleration)}")
    for index, contact in enumerate(equations.contacts):
        suffix = _suffix(index, model.contacts)
        lines += _contact_lines(printer, contact, suffix)
        by_force = {
            name: acceleration.diff(symbols.normal_force(index))
            for name, acceleration in equations.accelerations.items()
        }
        lines += _impact_lines(printer, contact, by_force, suffix)
    return [
        *lines,
        *_assumed_lines(model),
        f"  kinetic energy = {printer(equations.kinetic_energy)}",
        f"  potential energy = {printer(equations.potential_energy)}",
    ]


def law_lines(law: Law) -> list[str]:
    """The friction force of `law`, and what it can hold in stick."""
    import sympy

    names = ("v", "sgn(v)", "|v|", "F_N")
    v, sign, speed, normal_force = (sympy.Symbol(name, real=True) for name in names)
    parameters = {p.name: sympy.Symbol(p.name) for p in law.parameters}
    states = {state.name: sympy.Symbol(state.name, real=True) for state in law.states}
    slip = Slip(v, sign, speed, normal_force, states, law.row_symbols())
    lines = [f"  F_T = {_plain_text(law.force(slip, parameters))}      (slip velocity v)"]
    rates = law.rates(slip, parameters) if law.rates else {}
    lines += [f"  d{name}/dt = {_plain_text(rate)}" for name, rate in rates.items()]
    if law.capacity is not None:
        lines.append(
            f"  |F_T| <= {_plain_text(law.capacity(normal_force, parameters))}      (stick)"
        )
    if law.guards is not None:
        lines += _piece_lines(law, law.guards(slip, parameters)[0])
    return lines


def _piece_lines(law: Law, guards: Sequence[Any]) -> Iterator[str]:
    """The pieces of a law: their numbers, and what they lead to, of its first element."""
    import sympy

    names = law.row_symbols()[0]
    each = "each element" if law.elements > 1 else "the law"
    yield f"\n  {', '.join(map(str, names))} by the piece that {each} is in, and what ends it:"
    for piece in law.pieces:
        told = dict(zip(names, map(sympy.nsimplify, piece.row), strict=True))
        leads = ((out.to, guard) for out, guard in zip(piece.exits, guards, strict=True) if out)
        outs = [f"{_plain_text(guard.subs(told))} = 0, then {to}" for to, guard in leads]
        numbers = ", ".join(f"{x:g}" for x in piece.row)
        yield f"  {piece.name} ({numbers}): {'; '.join(outs)}"


def _plain_text(expression: Any) -> str:
    import sympy

    return sympy.sstr(expression).replace("**", "^")


def _contact_lines(printer: Callable[[Any], str], contact: Contact, suffix: str) -> Iterator[str]:
    named = {"v_rel": contact.slip_velocity, "F_N": contact.normal_force, "gap": contact.gap}
    if contact.restitution != 0:
        named["restitution"] = contact.restitution
    for name, expression in named.items():
        if expression is not None:
            yield f"  {name}{suffix} = {printer(expression)}"
    if contact.law is not None:
        given = ", ".join(f"{n} = {printer(e)}" for n, e in contact.law_parameters.items())
        yield f"  law{suffix} = {contact.law}" + (f" ({given})" if given else "")


def _impact_lines(
    printer: Callable[[Any], str], contact: Contact, by_force: Mapping[str, Any], suffix: str
) -> Iterator[str]:
    """What velocities do as a gap closes, by how accelerations follow its normal force."""
    import sympy

    if contact.gap is None:
        return
    if contact.impact == "none":
        yield f"  impact{suffix}: none, velocities go on as they are"
        return
    impulse, share = sympy.Symbol("impulse"), contact.restitution
    jumps = [f"{printer(impulse * of)} to {name}'" for name, of in by_force.items() if of != 0]
    after = f"is {printer(-share)} of what it was" if share != 0 else "is 0"
    if contact.closing_rate is not None:
        after = f"has changed by {printer(-(1 + share) * contact.closing_rate)}"
    yield f"  impact{suffix}: adds {', '.join(jumps)}; so that gap{suffix}' {after} after it"


def _assumed_lines(model: Model) -> Iterator[str]:
    from fiv_cli.case.assumed import assumed_of

    for sentence in assumed_of(model, model.default_options(), [model.default_law]):
        yield from wrap(sentence, 98, initial_indent="  ", subsequent_indent="  ")


def _suffix(contact: int, contacts: int) -> str:
    return "" if contacts == 1 else f"_{contact + 1}"


def _printer(model: Model) -> Callable[[Any], str]:
    """Text of an expression, its symbols by their contract names."""
    import sympy

    def text(expression: Any) -> str:
        expression = sympy.sympify(expression)
        names = {s: sympy.Symbol(_spoken(s.name, model.contacts)) for s in expression.free_symbols}
        return _plain_text(expression.xreplace(names))

    return text


def _spoken(name: str, contacts: int) -> str:
    """``p.mu_k`` -> ``mu_k``, ``q.x_dot`` -> ``x'``, ``F_T.0`` -> ``F_T`` (of several: F_T_1)."""
    kind, _, rest = name.partition(".")
    if kind in ("p", "q"):
        return f"{rest.removesuffix('_dot')}'" if rest.endswith("_dot") else rest
    if rest.isdigit():
        return f"{kind}{_suffix(int(rest), contacts)}"
    return name
