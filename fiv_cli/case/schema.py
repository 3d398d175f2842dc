"""The JSON schema of case files, for editors that complete and check while one types.

Pydantic gives the form; the names and meanings come from the model, law and analysis tables.
"""

from __future__ import annotations

from collections.abc import Iterable

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.settings import Schema, schema_of
from fiv_cli.case.excitation import forced
from fiv_cli.case.structure import CaseTable
from fiv_cli.friction import TANH_OF, all_laws
from fiv_cli.models import all_models
from fiv_cli.models.base import Model, Option, Parameter
from fiv_cli.notation.values import QUANTITY_SCHEMA

# Greek spellings of known names are accepted too; a schema cannot tell which ones mean what.
_GREEK_SPELLINGS: Schema = {"[^\\x00-\\x7F]": QUANTITY_SCHEMA}


def case_schema() -> Schema:
    """The JSON schema (draft 2020-12) of a case file."""
    schema = CaseTable.model_json_schema(by_alias=True)
    tables = schema["$defs"]
    models = all_models().values()
    _fill_model(tables["ModelTable"], models)
    _fill_friction(tables["FrictionTable"])
    _fill_analysis(tables["AnalysisTable"], all_analyses().values())
    _fill_grid(schema["properties"]["grid"], models)
    _fill_schedule(schema["properties"]["schedule"], models)
    _fill_forcing(schema["properties"]["forcing"], models)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _fill_model(table: Schema, models: Iterable[Model]) -> None:
    names = {model.name: model.title for model in models}
    table["properties"]["name"]["enum"] = list(names)
    table["allOf"] = [_when("name", model.name, _of_model(model)) for model in models]


def _of_model(model: Model) -> Schema:
    options = {option.name: _option(option) for option in model.options}
    parameters = {
        "properties": _parameters(model.parameters),
        "patternProperties": _GREEK_SPELLINGS,
        "additionalProperties": False,
    }
    chosen = {"properties": options, "additionalProperties": False}
    return {"properties": {"parameters": parameters, "options": chosen}}


def _option(option: Option) -> Schema:
    if option.read is None:
        return {"enum": list(option.choices), "description": option.meaning}
    about = f"{option.meaning}: {option.form}"
    return {"type": ["array", "string"], "description": about}


def _fill_friction(table: Schema) -> None:
    laws = all_laws()
    plain = [name for name in laws if not name.startswith(TANH_OF)]
    table["properties"]["law"]["enum"] = [*laws, "tanh"]
    table["properties"]["of"]["enum"] = plain
    table["properties"] |= _parameters(p for law in laws.values() for p in law.parameters)


def _fill_analysis(table: Schema, analyses: Iterable[Analysis]) -> None:
    table["properties"]["kind"]["enum"] = [analysis.kind for analysis in analyses]
    table["allOf"] = [
        _when("kind", analysis.kind, schema_of(analysis.settings)) for analysis in analyses
    ]


def _fill_grid(table: Schema, models: Iterable[Model]) -> None:
    """The names that an axis may have; their forms are those of any axis."""
    form = table["additionalProperties"]
    table["properties"] = _of_every_parameter(form, models)
    table["properties"]["friction"] = {**form, "description": "friction laws, by name"}
    table["properties"] |= {
        option.name: {"type": "array", "items": _option(option), "description": option.meaning}
        for model in models
        for option in model.options
        if option.read is not None
    }


def _fill_schedule(table: Schema, models: Iterable[Model]) -> None:
    """The names of what may vary in time."""
    table["properties"] = _of_every_parameter(table["additionalProperties"], models)


def _fill_forcing(table: Schema, models: Iterable[Model]) -> None:
    """The names of what may be forced."""
    form = table["additionalProperties"]
    for model in models:
        for name, meaning in forced(model).items():
            table.setdefault("properties", {}).setdefault(name, {**form, "description": meaning})


def _of_every_parameter(form: Schema, models: Iterable[Model]) -> dict[str, Schema]:
    """`form` under the name of every parameter of every model and law."""
    parameters = [p for model in models for p in model.parameters]
    parameters += [p for law in all_laws().values() for p in law.parameters]
    return {
        name: {**form, "description": about["description"]}
        for name, about in _parameters(parameters).items()
    }


def _parameters(parameters: Iterable[Parameter]) -> dict[str, Schema]:
    """Name -> what it takes, with symbol, unit, default and meaning; the first of a name counts."""
    found: dict[str, Schema] = {}
    for parameter in parameters:
        found.setdefault(parameter.name, _parameter(parameter))
    return found


def _parameter(parameter: Parameter) -> Schema:
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    default = "" if parameter.default is None else f", default {parameter.default:.12g}{unit}"
    return {
        "anyOf": [_number(parameter), {"type": "string"}],
        "description": f"{parameter.meaning} ({parameter.symbol}{default})",
    }


def _number(parameter: Parameter) -> Schema:
    number: Schema = {"type": "integer" if parameter.integer else "number"}
    if parameter.minimum != float("-inf"):
        number["exclusiveMinimum" if parameter.exclusive else "minimum"] = parameter.minimum
    if parameter.maximum != float("inf"):
        number["maximum"] = parameter.maximum
    return number


def _when(key: str, value: str, then: Schema) -> Schema:
    """Where `key` is `value`, the table is so."""
    return {"if": {"properties": {key: {"const": value}}, "required": [key]}, "then": then}
