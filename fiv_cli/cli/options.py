"""What to do in place of an option that a command does not have."""

from __future__ import annotations

from collections.abc import Mapping

import click

# What else an option may be called -> what to type; what begins with --, where it is known.
_OTHER_WORDS = {
    "jobs threads processes cores nproc cpus": "--workers",
    "force overwrite restart clean": "--fresh",
    "continue": "--resume",
    "dry_run": "fiv check CASE.toml",
    "format png pdf svg eps dpi": "-o FILE.pdf, or .png, or .svg",
    "font_size size figsize": "--width MM and --style paper or talk, which have sizes of their own",
    "undecided reason reasons failed": "fiv show FILE.nc --csv reason",
    "point where": "--at AXIS=VALUE",
    "param parameter parameters": "--set model.parameters.NAME=VALUE",
}
REPEATED = ("analysis", "claim", "figure", "initial")  # tables of which a case has several


def instead_of(word: str, command: click.Command, others: Mapping[str, click.Command]) -> str:
    """What to do where `command` has no option ``--word``; "" where nothing is known.

    Parameters
    ----------
    word : without its dashes
    others : name -> command, of all that there are
    """
    known, word = flags(command), word.replace("-", "_")
    called = next((flag for words, flag in _OTHER_WORDS.items() if word in words.split()), "")
    if called and (not called.startswith("--") or called.split()[0] in known):
        return called
    if word in others:
        return f"fiv {word}"
    if "--figure" in known:  # a plot
        return _in_a_figure("select" if word in ("at", "point", "where") else word)
    flag = "--" + word.replace("_", "-")
    having = [
        f"fiv {name} {flag}{_value_of(flag, other)}"
        for name, other in others.items()
        if flag in flags(other)
    ]
    return having[0] if having else _in_a_case(word, can_set="--set" in known)


def flags(command: click.Command) -> list[str]:
    """All options of a command, a pair of on and off as both."""
    options = [one for one in command.params if isinstance(one, click.Option)]
    return [
        max(names, key=len) for one in options for names in (one.opts, one.secondary_opts) if names
    ]


def _value_of(flag: str, command: click.Command) -> str:
    """What an option of a command takes."""
    (own,) = (one for one in command.params if flag in (*one.opts, *one.secondary_opts))
    takes_none = isinstance(own, click.Option) and (own.is_flag or own.count)
    return "" if takes_none else f" {own.metavar or str(own.name).upper()}"


def _in_a_figure(word: str) -> str:
    if ("figure", "figure") not in _places_of(word):
        return ""
    return (
        f"write {word} under [[figure]] in the case (fiv kinds figure), then `fiv run` it: that "
        "computes nothing anew (of a motion: the same `fiv history` again)"
    )


def _in_a_case(word: str, *, can_set: bool) -> str:
    """Where in a case it is written: a table, a key of one, or a parameter."""
    from fiv_cli.case.kinds import TABLES

    if word in TABLES:
        return f"write it in the case: fiv kinds {word}"
    for table, kind in _places_of(word):
        place = f"[[{table}]]" if table in REPEATED else f"[{table}]"
        return f"write {word} under {place} in the case: fiv kinds {kind}"
    if word not in _parameters():
        return ""
    parameter = f"model.parameters.{word}"
    return f"--set {parameter}=VALUE" if can_set else f"write {parameter} = VALUE in the case"


def _places_of(word: str) -> list[tuple[str, str]]:
    """(table, its kind) in a case that has a key `word`; tables without kinds as their own."""
    from fiv_cli.case.kinds import TABLES, all_kinds, keys_in

    of_kinds = [(kind.table, kind.name, kind.keys) for kind in all_kinds()]
    of_tables = [(name, name, keys_in(form)) for name, (_, form) in TABLES.items()]
    return [
        (table, kind)
        for table, kind, keys in (*of_kinds, *of_tables)
        if word in {key.name for key in keys}
    ]


def _parameters() -> set[str]:
    from fiv_cli.friction import all_laws
    from fiv_cli.models import all_models

    models = (one.name for model in all_models().values() for one in model.parameters)
    return {*models, *(one.name for law in all_laws().values() for one in law.parameters)}
