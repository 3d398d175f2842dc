"""What a case leaves to its model and its laws: defaults, what is assumed, where laws differ."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import chain, compress

from fiv_cli.analyses import get_analysis
from fiv_cli.case.assumed import assumed_of_contacts
from fiv_cli.case.case import Case
from fiv_cli.friction import get_law
from fiv_cli.friction.base import Law
from fiv_cli.models import get_model
from fiv_cli.models.base import Model
from fiv_cli.models.excitation import terms_of

NAMED = ("preload", "speed", "friction", "amplitude", "frequency")
"""Roles of parameters of a model whose defaults are named; of the others it is said how many."""


def defaults(case: Case, given: Collection[str]) -> dict[str, float | str]:
    """The values in force, SI, that the case does not give, but those `given` otherwise; of one
    that follows another parameter the name of this."""
    owners = _owners(case)
    found: dict[str, float | str] = {}
    for name, values in _left(case, given).items():
        agreed = set(values) == owners[name] and len({*values.values()}) == 1
        found |= {name: next(iter(values.values()))} if agreed else _by_law(name, values)
    return found | _following(case, given)


def _following(case: Case, given: Collection[str]) -> dict[str, str]:
    """Parameter -> the one whose value it has, where the case says neither that nor a value."""
    model, known = get_model(case.model), {key.rpartition(".")[2] for key in case.parameters}
    *_, stated = terms_of(model.name)
    decided = {*known, *case.schedule.names, *given, *stated, *(axis.name for axis in case.axes)}
    tables = [model.parameters_under(get_law(law)) for law in case.laws]
    return {
        one.name: one.default_from
        for one in dict.fromkeys(chain.from_iterable(tables))
        if one.default_from is not None and one.name not in decided
    }


def defaults_text(case: Case, given: Collection[str]) -> list[str]:
    """Those of the laws, and of the model those that decide what it does; of the rest how many."""
    model, left = get_model(case.model), defaults(case, given)
    plain, *_ = terms_of(model.name)
    counted = {one.name for one in model.parameters if one.role not in NAMED} & left.keys()
    told = [
        f"{name} = {value if isinstance(value, str) else f'{value:.12g}'}"
        for name, value in left.items()
        if name not in counted
    ]
    more = f"{len(counted)} {'more' if told else 'parameters'}: fiv models {plain}"
    set_here = {name for law in case.laws for name in model.defaults_of(get_law(law))}
    theirs = [name for name in _left(case, given) if name in set_here]
    of_model = f"  {', '.join(theirs)}: the default of {plain}, not of the law"
    line = f"  by default, in SI: {', '.join([*told, *[more] * bool(counted)])}"
    return [*[line] * bool(left), *_options_text(case, model), *[of_model] * bool(theirs)]


def _options_text(case: Case, model: Model) -> list[str]:
    """The options of a model that a case leaves as they are."""
    axes = {axis.name for axis in case.axes}
    left = [one for one in model.options if case.options[one.name] == one.default]
    told = [f'{one.name} = "{one.default}"' for one in left if one.name not in axes]
    return [f"  options by default: {', '.join(told)}"] * bool(told)


def unequal_defaults(case: Case) -> list[str]:
    """A sentence for each parameter that laws of the case have in common, and not its default."""
    tables = {law: {p.name: p.unit for p in get_law(law).parameters} for law in case.laws}
    return [
        f"the laws' defaults of {name} differ ("
        f"{', '.join(f'{key} = {value:.12g}' for key, value in _by_law(name, values).items())}): "
        f"to compare the laws at one, write {name} = VALUE under [friction]"
        for name, values in _left(case, ()).items()
        if len({*values.values()}) > 1 and len({tables[law][name] for law in values}) == 1
    ]


def remarks(case: Case) -> list[str]:
    """What is assumed where contacts stick at once, and what may be meant so in a law."""
    own = [law for law in map(get_law, case.laws) if law.origin is not None]
    assumed = [*assumed_of_contacts(case), *_level(case), *_rising(case)]
    return [*assumed, *(_asymmetries(own) if own else []), *_fed(get_model(case.model))]


def _fed(model: Model) -> Iterator[str]:
    if model.origin is not None:
        from fiv_cli.own.mechanics import fed_by_damping  # brings SymPy

        yield from filter(None, [fed_by_damping(model)])


def _level(case: Case) -> Iterator[str]:
    """Laws that do not fall from stick to slip, because the model's mu_s is mu_k."""
    *_, stated = terms_of(case.model)
    given = {*case.explicit, *case.schedule.names, *stated, *(axis.name for axis in case.axes)}
    for law in map(get_law, case.laws):
        of_law = {p.name: p for p in get_model(case.model).parameters_under(law)}
        static = of_law.get("mu_s")
        left = not {"mu_s", f"{law.name}.mu_s"} & given
        if static and static.default_from == "mu_k" and left and law.name != "coulomb":
            yield (
                f"mu_s = mu_k by default on {case.model}: under {law.name} friction does not fall "
                "with speed; write mu_s = VALUE under [friction]"
            )


def _rising(case: Case) -> Iterator[str]:
    """Laws that rise with speed somewhere in the case, for which no motion may be followed."""
    linear = any(get_analysis(spec.kind).linear for spec in case.analyses)
    for law in case.laws if linear else ():
        above = [pair for pair in _met(case, law) if pair[0] > pair[1]]
        if law != "coulomb" and above:
            kinetic, static = max(above)
            yield (
                f"mu_k = {kinetic:.12g} is above mu_s = {static:.12g}: under {law} "
                "friction rises with speed there; write a greater mu_s, or none where it follows "
                "mu_k, under [friction]"
            )


def _met(case: Case, law: str) -> list[tuple[float, float]]:
    """Values of mu_k and mu_s that stand together: of axes that do not advance so the extremes."""
    names = ("mu_k", "mu_s")
    of = {name: _values(case, law, name) for name in names}
    for group in map(set, case.zips):
        if "friction" in group:
            is_own = [one == law for one in case.axis("friction").values]
            of |= {name: [*compress(of[name], is_own)] for name in group.intersection(names)}
        if group.issuperset(names):
            return [*zip(*of.values(), strict=True)]
    kinetic, static = of.values()
    return [(max(kinetic), min(static))] if kinetic and static else []


def _values(case: Case, law: str, name: str) -> list[float]:
    """The values of a law's parameter: of its axis, its bracket, or the one; none if it follows."""
    for axis in case.axes:
        if axis.name in (name, f"{law}.{name}"):
            return [*axis.values]
    for settings in (spec.settings for spec in case.analyses):
        varied = settings.get("parameter")
        if varied is not None and name in (varied.name, *varied.followers):
            return [] if name in varied.followers else [*settings["bracket"]]
    return [value for key, value in case.parameters.items() if key in (name, f"{law}.{name}")]


def _asymmetries(laws: Sequence[Law]) -> Iterator[str]:
    from fiv_cli.own.check import asymmetry  # brings SymPy

    return filter(None, map(asymmetry, laws))


def _left(case: Case, given: Collection[str]) -> dict[str, dict[str, float]]:
    """Parameter -> law -> the default in force under it, where the case gives no value."""
    owners, decided = _owners(case), {*case.explicit, *case.schedule.names, *given}
    found: dict[str, dict[str, float]] = {}
    for key, value in case.parameters.items():
        law, _, name = key.rpartition(".")
        own = [law] if law else [one for one in case.laws if one in owners[name]]
        left = {one: value for one in own if not {name, f"{one}.{name}"} & decided}
        if left:
            found.setdefault(name, {}).update(left)
    return found


def _owners(case: Case) -> dict[str, set[str]]:
    """Parameter -> the laws under which the model has it."""
    owners: dict[str, set[str]] = {}
    for law in case.laws:
        for parameter in get_model(case.model).parameters_under(get_law(law)):
            owners.setdefault(parameter.name, set()).add(law)
    return owners


def _by_law(name: str, values: dict[str, float]) -> dict[str, float]:
    return {f"{law}.{name}": value for law, value in values.items()}
