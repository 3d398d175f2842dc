"""``fiv models``: the models and friction laws, their parameters and equations."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

import click

from fiv_cli.cli.common import json_option, print_json, print_table, with_option
from fiv_cli.errors import UsageError
from fiv_cli.notation.names import pick

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from fiv_cli.friction.base import Law
    from fiv_cli.models.base import Model, Option, Parameter, State

MEASURED = (
    'measured friction, a file beside the case: law = "FILE.csv", whose rows are slip velocity '
    "and coefficient under a heading\n"
)
KINDS = (
    "set-valued: it sticks, and an event lies where it begins or ends; regularised: smooth, it\n"
    "creeps; dynamic: internal states move with the slip"
)


@click.command("models")
@click.argument("name", required=False)
@click.argument("of_law", required=False, metavar="[LAW]")
@click.option("--laws", "want_laws", is_flag=True, help="Friction laws instead of models.")
@click.option("--law", metavar="LAW", help="The same as LAW after the NAME of a model.")
@click.option(
    "--option",
    "chosen",
    metavar="OPTION=CHOICE",
    multiple=True,
    help="States and equations of the model NAME under this option (repeatable).",
)
@json_option
@with_option
def command(
    name: str | None,
    of_law: str | None,
    want_laws: bool,
    law: str | None,
    chosen: tuple[str, ...],
    as_json: bool,
) -> None:
    """List the mechanical models, or print everything about the model or law called NAME, or which
    of them have the parameter or state NAME.

    For one model: its parameters with symbol, unit, default, range and the equation that
    introduces them, its states and options, the friction laws it takes, and its equations, under
    its default law or LAW. Of a table of measured friction, `fiv models FILE.csv`: what was
    read.

    \b
    Examples:
      fiv models
      fiv models pin-on-disc    # then: fiv new pin-on-disc
      fiv models pin-on-disc stribeck
      fiv models disc-nonlinear-contact --option geometry=linear
      fiv models k_nl           # which models have it
      fiv models --laws
      fiv models stribeck       # then: fiv plot --law stribeck
    """
    from fiv_cli.friction import all_laws
    from fiv_cli.models import all_models
    from fiv_cli.own.load import following, know_installed, seek

    know_installed()
    if law and of_law and law != of_law:
        raise UsageError(f"two laws, {of_law} and {law}\nnext: fiv models {name} {law}")
    law = law or of_law
    name = name if name is None else seek(name)
    laws = all_laws()
    if name is not None and not want_laws and not (name in all_models() or name in laws):
        what = "model or friction law"
        if not (law or chosen):
            what += ", parameter, state or option"
            if having := _having(name):
                _show_having(name, having, as_json)
                return
        known = dict.fromkeys([*all_models(), *laws])
        lists = following("models", name, "fiv models, or fiv models --laws")
        pick(name, known, what, lists)
    if law is not None or chosen:
        _show_under(_under(name, chosen, law), law and seek(law), as_json)
    elif want_laws or name in laws:
        _show_laws(name, as_json)
    else:
        _show_models(name, as_json)


def _having(name: str) -> list[tuple[str, ...]]:
    """Model or law, unit, default and meaning of each parameter, state or option called `name`, and
    what model or law that is."""
    from fiv_cli.friction import TANH_OF, all_laws
    from fiv_cli.models import all_models

    models = all_models().values()
    tables = [(one.name, one.parameters) for one in models]
    tables += [(one.name, one.parameters) for one in all_laws().values()]
    held = [(of, p) for of, table in tables for p in table if p.name == name]
    plain = [(of, p) for of, p in held if not of.startswith(TANH_OF)]
    found = [(of, p.unit, _default(p), p.meaning) for of, p in plain or held]
    for model in models:
        states = model.states(model.default_options())
        found += [(model.name, s.unit, "", f"state: {s.meaning}") for s in states if s.name == name]
        options = [option for option in model.options if option.name == name]
        found += [(model.name, "", o.default, f"option: {o.meaning}") for o in options]
    titles = {model.name: model.title for model in models}
    titles |= {law.name: law.title for law in all_laws().values()}
    return [(*row, titles[row[0]]) for row in found]


def _show_having(name: str, having: Sequence[tuple[str, ...]], as_json: bool) -> None:
    columns = ("of", "unit", "default", "meaning", "title")
    if as_json:
        print_json({"name": name, "of": [dict(zip(columns, row, strict=True)) for row in having]})
    else:
        print_table(f"{name} (fiv models MODEL, or LAW, says more)", columns, having)


def _under(name: str | None, chosen: Sequence[str], law: str | None) -> Model:
    """The model of that name under options that are not its defaults; UsageError if it is none."""
    from fiv_cli.models import all_models

    if name not in all_models():
        told = f"{law}: a law is for a model\nnext: fiv models {law}, or fiv models MODEL {law}"
        options = "--option is for a model\nnext: fiv models NAME --option OPTION=CHOICE"
        raise UsageError(options if law is None else told)
    model = all_models()[name]
    texts = dict(_option_of(model, one) for one in chosen)
    options_of = (replace(o, default=texts.get(o.name, o.default)) for o in model.options)
    return replace(model, options=tuple(options_of))


def _option_of(model: Model, said: str) -> tuple[str, str]:
    """The name and the text of ``OPTION=CHOICE``; UsageError where the model has no such."""
    key, _, value = (part.strip() for part in said.partition("="))
    of = {option.name: option for option in model.options}
    if not of:
        raise UsageError(f"{model.name} has no options\nnext: fiv models {model.name}")
    option = pick(key, of, f"option of {model.name}", f"fiv models {model.name}")
    try:
        return key, option.text(value)
    except ValueError as error:
        raise UsageError(f"--option {said}: {error}\nmust be {option.allowed}") from None


def _show_under(model: Model, law: str | None, as_json: bool) -> None:
    """A model with a law that it has not by default, if one is named."""
    from fiv_cli.friction import all_laws, why_unfit

    if law is None:
        print_json(_model_document(model)) if as_json else _print_model(model, model.default_law)
        return
    under = pick(law, all_laws(), "friction law", "fiv models --laws")
    unfit = why_unfit(model, under)
    if unfit:
        raise UsageError(f"{unfit}\nnext: fiv models {model.name} lists those that it takes")
    if as_json:
        adopted = replace(under, parameters=model.adopted(under))
        print_json(_model_document(model) | {"law": _law_document(adopted)})
    else:
        _print_model(model, law)


def _show_models(name: str | None, as_json: bool) -> None:
    from fiv_cli.models import all_models

    models = all_models()
    if name is not None:
        _show_under(models[name], None, as_json)
    elif as_json:
        print_json({"models": [_model_document(model) for model in models.values()]})
    else:
        rows = [(model.name, model.title, model.reference) for model in models.values()]
        print_table("Models (fiv models NAME says more)", ("name", "what", "reference"), rows)


def _show_laws(name: str | None, as_json: bool) -> None:
    from fiv_cli.friction import all_laws

    laws = all_laws()
    if name is not None:
        law = pick(name, laws, "friction law", "fiv models --laws")
        print_json(_law_document(law)) if as_json else _print_law(law)
    elif as_json:
        print_json({"laws": [_law_document(law) for law in laws.values()]})
    else:
        rows = [(law.name, law.kind, law.title, _names(law.parameters)) for law in laws.values()]
        columns = ("name", "kind", "what", "parameters")
        print_table('Friction laws (law = "NAME")', columns, rows)
        click.echo('\n"tanh of LAW" is written: law = "tanh", of = "LAW"\n' + MEASURED + KINDS)


def _model_document(model: Model) -> dict[str, object]:
    """Everything the tables of a model say."""
    from fiv_cli.case.excitation import forced
    from fiv_cli.friction import laws_of

    keys = ("name", "title", "reference", "parameters", "options", "law_defaults", "contacts")
    return {key: getattr(model, key) for key in keys} | {
        "options": _plain_options(model),
        "chosen": model.default_options(),
        "forcing": forced(model),
        "states": model.states(model.default_options()),
        "laws": laws_of(model),
    }


def _law_document(law: Law) -> dict[str, object]:
    """Everything the table of a law says."""
    keys = ("name", "title", "reference", "kind", "parameters", "states")
    own = {"sticks": law.capacity is not None, "defaults_on": _defaults_on(law)}
    return {key: getattr(law, key) for key in keys} | own


def _defaults_on(law: Law) -> dict[str, dict[str, float | str]]:
    """Model -> the defaults that parameters of the law have on it, of those that have their own."""
    from fiv_cli.friction import laws_of
    from fiv_cli.models import all_models

    own = {
        model.name: model.defaults_of(law)
        for model in all_models().values()
        if law.name in laws_of(model)
    }
    return {name: defaults for name, defaults in own.items() if defaults}


def _print_model(model: Model, law: str) -> None:
    click.echo(f"{model.name}: {model.title}\n{model.reference}\n")
    _print_parameters("Parameters, under [model.parameters]", model.parameters)
    states = model.states(model.default_options())
    _print_states("States (the velocity of x is x_dot)", states)
    _print_options(model)
    _print_forces(model)
    if model.contacts:
        _print_laws_taken(model)
        _print_law_parameters(model, law)
        _print_equations(replace(model, default_law=law))


def _how_small(state: State) -> str:
    """Up to where the equations hold that take a state as small."""
    told = f", small in these equations: up to {state.small:g} {state.unit}"
    return told if isfinite(state.small) else ""


def _print_states(title: str, states: Sequence[State]) -> None:
    columns = ("name", "symbol", "unit", "meaning")
    if states:
        rows = [(s.name, s.symbol, s.unit, s.meaning + _how_small(s)) for s in states]
        click.echo()
        print_table(title, columns, rows)


def _print_options(model: Model) -> None:
    """With the choice of each under which the rest is printed, where that is not the default."""
    if not model.options:
        return
    plain, chosen = _plain_options(model), [*model.default_options().values()]
    rows = [(o.name, o.form or " | ".join(o.choices), o.default, o.meaning) for o in plain]
    columns = ["name", "choices", "default", "meaning"]
    title = "Options, under [model.options]"
    click.echo()
    if chosen == [option.default for option in plain]:
        print_table(title, columns, rows)
    else:
        here = [(*row[:3], own, row[3]) for row, own in zip(rows, chosen, strict=True)]
        print_table(title, [*columns[:3], "chosen", columns[3]], here)


def _plain_options(model: Model) -> tuple[Option, ...]:
    """The options with the defaults of the model itself."""
    from fiv_cli.models import all_models

    return all_models()[model.name].options


def _print_forces(model: Model) -> None:
    """What a case may force besides, and how; the parameters of that are axes."""
    from fiv_cli.case.excitation import forced
    from fiv_cli.case.structure import ForceTable

    rows = [(name, _axes_of(name), meaning) for name, meaning in forced(model).items()]
    if rows:
        title = f"Forces, none unless under [forcing]: NAME = {ForceTable.example}"
        click.echo()
        print_table(title, ("name", "axes of a grid", "what it is"), rows)
    if model.contacts:
        click.echo("\nAny parameter varies harmonically under [schedule]: fiv kinds harmonic")


def _axes_of(name: str) -> str:
    from fiv_cli.models.excitation import BASE, NAMES

    keys = ("amplitude", "omega", "phase", *(["constant"] if name != BASE else []))
    return ", ".join(NAMES[key].format(name) for key in keys)


def _print_laws_taken(model: Model) -> None:
    """By kind; those that the model cannot take, with the reason."""
    from fiv_cli.friction import TANH_OF, all_laws, why_unfit

    laws = {name: law for name, law in all_laws().items() if not name.startswith(TANH_OF)}
    fit = {name: law for name, law in laws.items() if not why_unfit(model, law)}
    click.echo(f"\nFriction laws (default: {model.default_law})")
    for kind in dict.fromkeys(law.kind for law in fit.values()):
        click.echo(f"  {kind}: {', '.join(name for name in fit if fit[name].kind == kind)}")
    click.echo(f'  regularised: each set-valued law (law = "tanh", of = "{next(iter(fit))}")')
    for law in [law for name, law in laws.items() if name not in fit]:
        click.echo(f"  not {why_unfit(model, law)}")


def _print_law_parameters(model: Model, law: str) -> None:
    """The parameters of a law, with the defaults they have on this model."""
    from fiv_cli.friction import get_law

    parameters = model.adopted(get_law(law))
    click.echo()
    _print_parameters(f"Parameters of {law}, under [friction]", parameters)
    those = "every law" if model.origin else "every law of fiv"
    if model.law_defaults:
        click.echo(f"\nOn this model, under {those}: {_assigned(model.law_defaults)}")


def _print_law(law: Law) -> None:
    from fiv_cli.cli.equations import law_lines

    click.echo(f"{law.name}: {law.title}\n{law.reference}\n")
    _print_parameters("Parameters, under [friction]", law.parameters)
    _print_states("States of its own, which begin at zero", law.states)
    rows = [(model, _assigned(defaults)) for model, defaults in _defaults_on(law).items()]
    if rows:
        click.echo()
        print_table("Models that have defaults of their own", ("model", "defaults"), rows)
    click.echo("\n" + "\n".join(law_lines(law)))
    if law.capacity is None:
        click.echo("\nIt never sticks: it has no static coefficient.")
    if law.origin is not None:
        _print_remark(law)


def _print_remark(law: Law) -> None:
    """What may be meant so in a law of one's own, and may be a slip of the pen."""
    from fiv_cli.own.check import asymmetry

    if remark := asymmetry(law):
        click.echo(f"\nRemark: {remark}.")


def _print_parameters(title: str, parameters: tuple[Parameter, ...]) -> None:
    rows = [
        (p.name, p.role, p.symbol, p.unit, _default(p), _range(p), p.meaning, p.equation)
        for p in parameters
    ]
    columns = ("name", "role", "symbol", "unit", "default", "range", "meaning", "equation")
    print_table(title, columns, rows)


def _assigned(defaults: Mapping[str, float | str]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in defaults.items())


def _default(parameter: Parameter) -> str:
    value = parameter.default
    return f"= {parameter.default_from}" if value is None else f"{value:.12g}"


def _range(parameter: Parameter) -> str:
    low, high = parameter.minimum, parameter.maximum
    if (low, high) == (float("-inf"), float("inf")):
        return "any"
    if high == float("inf"):
        return f"{'>' if parameter.exclusive else '>='} {low:g}"
    return f"{'(' if parameter.exclusive else '['}{low:g}, {high:g}]"


def _names(parameters: tuple[Parameter, ...]) -> str:
    return ", ".join(parameter.name for parameter in parameters)


def _print_equations(model: Model) -> None:
    from fiv_cli.cli.equations import equation_lines, law_lines
    from fiv_cli.friction import get_law

    law = get_law(model.default_law)
    click.echo("\n" + "\n".join(equation_lines(model)))
    click.echo("\n".join(law_lines(law)))
    if model.origin is not None:
        from fiv_cli.own.mechanics import fed_by_damping

        if remark := fed_by_damping(model):
            click.echo(f"\nRemark: {remark}")
