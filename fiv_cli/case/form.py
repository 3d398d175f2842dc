"""The form of a case file: each of its tables read for itself.

What is wrong here is told before any name is looked up: which tables and keys there are, of what
type their values are, and the words that decide what else may stand in a case, the model and the
kinds of analyses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from pydantic import BaseModel

from fiv_cli.analyses import all_analyses
from fiv_cli.case.overrides import WITH_A_DOT, names_of
from fiv_cli.case.report import MISSING, Path, Report
from fiv_cli.case.structure import (
    SCHEMA_VERSION,
    AnalysisTable,
    CaseTable,
    ClaimTable,
    CurveTable,
    FigureTable,
    ForceTable,
    FrictionTable,
    HeaderTable,
    InitialTable,
    ModelTable,
    RangeTable,
    SolverTable,
    SweepTable,
)
from fiv_cli.case.tables import keys_of, read_table, read_tables
from fiv_cli.case.words import called_here
from fiv_cli.friction import all_laws
from fiv_cli.friction.tabulated import FORM, SUFFIX
from fiv_cli.models import all_models
from fiv_cli.models.excitation import NAMES
from fiv_cli.notation.names import axis_name, suggest, surely_meant
from fiv_cli.notation.values import describe
from fiv_cli.own.load import files_with, know_installed, know_table, to_mend

T = TypeVar("T", bound=BaseModel)
V = TypeVar("V")

_MODELS = "`fiv models` says what each is; one of your own is named with --with FILE.py"
_KINDS = "`fiv kinds` says what there is: analyses compute, figures draw"


class Entry(NamedTuple, Generic[V]):
    """A key of ``[grid]``, ``[schedule]`` or ``[forcing]``: its name, its place, what it holds."""

    name: str
    place: Path
    value: V


@dataclass(frozen=True)
class Form:
    """The tables of a case file, each of a sound form."""

    header: HeaderTable
    model: ModelTable
    friction: FrictionTable
    grid: tuple[Entry[list[Any] | RangeTable], ...]
    schedule: tuple[Entry[CurveTable], ...]
    forcing: tuple[Entry[ForceTable], ...]
    sweep: SweepTable
    initial: tuple[InitialTable, ...]
    analysis: tuple[AnalysisTable, ...]
    figure: tuple[FigureTable, ...]
    claim: tuple[ClaimTable, ...]
    solver: SolverTable

    @property
    def _harmonic(self) -> Iterator[Entry[CurveTable] | Entry[ForceTable]]:
        yield from self.schedule
        yield from self.forcing

    def places_of(self, name: str) -> list[Path]:
        """Where the case fixes what an axis, or the time, varies."""
        if name == "friction":
            return [("friction", "law")] if self.friction.law is not None else []
        friction = self.friction.model_extra or {}
        tables: dict[Path, Mapping[str, Any]] = {
            ("model", "parameters"): self.model.parameters,
            ("model", "options"): self.model.options,
            ("friction",): friction,
        }
        tables |= {("friction", k): v for k, v in friction.items() if isinstance(v, dict)}
        fixed = [
            (*path, key)
            for path, table in tables.items()
            for key in table
            if axis_name(key) == name
        ]
        return fixed + [
            (*entry.place, key)
            for entry in self._harmonic
            for key in entry.value.model_fields_set & NAMES.keys()
            if NAMES[key].format(entry.name) == name
        ]


def read_form(document: Mapping[str, Any], report: Report) -> Form:
    """The tables of `document`; CaseError with all that is wrong with their form."""
    header = {"schema": SCHEMA_VERSION}
    header |= {key: document[key] for key in keys_of(HeaderTable) if key in document}
    form = Form(
        header=_one(HeaderTable, header, (), report),
        model=_one(ModelTable, document.get("model", {"name": ""}), ("model",), report),
        friction=_one(FrictionTable, document.get("friction", {}), ("friction",), report),
        grid=tuple(_axes(document, report)),
        schedule=tuple(_tables_of(document, "schedule", CurveTable, report)),
        forcing=tuple(_tables_of(document, "forcing", ForceTable, report)),
        sweep=_one(SweepTable, document.get("sweep", {}), ("sweep",), report),
        initial=read_tables(InitialTable, document.get("initial", []), "initial", report),
        analysis=read_tables(AnalysisTable, document.get("analysis", []), "analysis", report),
        figure=read_tables(FigureTable, document.get("figure", []), "figure", report),
        claim=read_tables(ClaimTable, document.get("claim", []), "claim", report),
        solver=_one(SolverTable, document.get("solver", {}), ("solver",), report),
    )
    _refuse_unknown_words(document, report)
    report.raise_if_broken()
    return form


def known_tables(document: Mapping[str, Any], report: Report) -> dict[str, Any]:
    """The tables of `document` under the names that are meant; a note of each that is unknown."""
    known, found = keys_of(CaseTable), dict(document)
    for key in [key for key in document if key not in known]:
        hint = _element_called(key, document) or suggest(key, known) or _home_of(key)
        hint = hint or called_here(key)
        report.unknown((key,), f"unknown table or key {key!r}", key, known, hint, of_key=True)
        value, meant = found.pop(key), surely_meant(key, [one for one in known if one not in found])
        found |= {meant: value} if meant is not None else {}
    needed = {
        "schema": f"schema = {SCHEMA_VERSION}",
        "model": "the table [model] with its name",
        "analysis": "one [[analysis]] at least",
    }
    for key, what in needed.items():
        if found.get(key) in (None, []):
            report.add((key,), MISSING, what)
    return found


def _element_called(key: str, document: Mapping[str, Any]) -> str:
    """What to write for the name of an analysis, say, that was taken for that of a table."""
    arrays = {table: value for table, value in document.items() if isinstance(value, list)}
    holding = [table for table, elements in arrays.items() if key in names_of(elements)]
    return f"{key!r} is an [[{holding[0]}]]: --set {holding[0]}.{key}.KEY=VALUE" if holding else ""


def _home_of(key: str) -> str:
    """The table in which a key stands that was written above all tables."""
    tables: dict[str, type[BaseModel]] = {"model": ModelTable, "friction": FrictionTable}
    tables["sweep"] = SweepTable
    homes = [f"[{name}]" for name, form in tables.items() if key in keys_of(form)]
    parameters = {p.name for model in all_models().values() for p in model.parameters}
    laws = {p.name for law in all_laws().values() for p in law.parameters}
    homes += ["[model.parameters], or as an axis in [grid]"] * (key in parameters)
    homes += ["[friction], or as an axis in [grid]"] * (key in laws)
    return f"{key!r} stands in {homes[0]}" if homes else ""


def _refuse_unknown_words(document: Mapping[str, Any], report: Report) -> None:
    """Note a model and kinds of analyses that there are not: without them no name means a thing."""
    for place, name in _tables(document):
        with report.noting(place, f"{name!r} with {FORM}"):
            know_table(name, report.source)
    if not {"tanh", *all_models(), *all_laws()}.issuperset(_words(document)):
        know_installed()
    models = {name: model.title for name, model in all_models().items()}
    _check_word(document.get("model"), "name", ("model",), models, _MODELS, report)
    _refuse_misplaced_laws(document.get("friction"), report)
    kinds = {name: analysis.title for name, analysis in all_analyses().items()}
    analyses = document.get("analysis")
    for index, table in enumerate(analyses if isinstance(analyses, list) else []):
        _check_word(table, "kind", ("analysis", index), kinds, _KINDS, report)


def _words(document: Mapping[str, Any]) -> Iterator[str]:
    """What a case calls its model and its laws."""
    tables = {"model": ("name",), "friction": ("law", "of"), "grid": ("friction",)}
    for name, keys in tables.items():
        table = document.get(name)
        for word in (table.get(key) for key in keys) if isinstance(table, dict) else ():
            yield from (w for w in (word if isinstance(word, list) else [word]) if type(w) is str)


def _tables(document: Mapping[str, Any]) -> Iterator[tuple[Path, str]]:
    """The files that a case names as laws, and where."""
    for place in (("friction", "law"), ("grid", "friction")):
        table = document.get(place[0])
        word = table.get(place[1]) if isinstance(table, dict) else None
        for name in word if isinstance(word, list) else [word]:
            if isinstance(name, str) and name.endswith(SUFFIX):
                yield place, name


def own_file(word: str, report: Report) -> str:
    """That a file beside the case has what it names, which is then called for; empty: none has."""
    files = files_with(word, report.source)
    for file in files:
        report.call_for(str(file))
    told = (f"{file} has it; it is run where you say so{to_mend(file)}" for file in files)
    return next(told, "")


def _refuse_misplaced_laws(friction: object, report: Report) -> None:
    """Note a key of ``[friction]`` that holds the name of a law, but is none that may."""
    laws = {*all_laws(), "tanh"}
    for key, value in friction.items() if isinstance(friction, dict) else ():
        if key not in ("law", "of") and isinstance(value, str) and value in laws:
            hint = f'write law = "{value}"'
            report.unknown(("friction", key), f"unknown key {key!r}", key, ("law", "of"), hint)


def _check_word(
    table: object, key: str, path: Path, known: Mapping[str, str], listed: str, report: Report
) -> None:
    word = table.get(key) if isinstance(table, dict) else None
    if isinstance(word, str) and word not in known:
        file = own_file(word, report) if path == ("model",) else ""
        hint = file or called_here(word) or suggest(word, known) or listed
        report.unknown((*path, key), f"there is no {path[0]} {word!r}", word, known, hint)


def _one(form: type[T], raw: object, path: Path, report: Report) -> T:
    """`raw` as a `form`; an unfilled one, and a note, where it is none."""
    return read_table(form, raw, path, report) or form.model_construct()


def _axes(document: Mapping[str, Any], report: Report) -> Iterator[Entry[list[Any] | RangeTable]]:
    for name, place, value in _entries(document, "grid", RangeTable, report):
        if isinstance(value, dict):
            yield Entry(name, place, _one(RangeTable, value, place, report))
        elif isinstance(value, list):
            yield Entry(name, place, value)
        else:
            report.add(
                place,
                f"an axis is a list or a range, not {describe(value)}",
                "[1, 2, 3], { start, stop, step } or { start, stop, num, scale }",
                "a single value is fixed under [model.parameters] or [friction]",
            )


def _tables_of(
    document: Mapping[str, Any], key: str, form: type[T], report: Report
) -> Iterator[Entry[T]]:
    for name, place, value in _entries(document, key, form, report):
        yield Entry(name, place, _one(form, value, place, report))


def _entries(
    document: Mapping[str, Any], key: str, form: type[BaseModel], report: Report
) -> Iterator[Entry[object]]:
    """The keys of a table of which each holds a `form`; a nested one is a name with a dot."""
    table = document.get(key, {})
    if not isinstance(table, dict):
        report.add((key,), f"must be a table, not {describe(table)}")
        return
    for name, value in table.items():
        nested = isinstance(value, dict) and not keys_of(form).keys() & value.keys()
        if nested and name in WITH_A_DOT:
            for inner, own in value.items():
                yield Entry(axis_name(f"{name}.{inner}"), (key, name, inner), own)
        else:
            yield Entry(axis_name(name), (key, name), value)
