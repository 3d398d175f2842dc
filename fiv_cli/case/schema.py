"""The JSON schema of case files, for editors that complete and check while one types.

Pydantic gives the form; the names and meanings come from the model, law and analysis tables.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.base import Analysis, Setting
from fiv_cli.case.structure import CaseTable, QuestionTable, SectionTable
from fiv_cli.friction import TANH_OF, all_laws
from fiv_cli.models import all_models
from fiv_cli.models.base import Model, Option, Parameter
from fiv_cli.notation.values import INTERVAL_SCHEMA, QUANTITY_SCHEMA

Schema = dict[str, Any]

# Greek spellings of known names are accepted too; a schema cannot tell which ones mean what.
_GREEK_SPELLINGS: Schema = {"[^\\x00-\\x7F]": QUANTITY_SCHEMA}


def case_schema() -> Schema:
    """The JSON schema (draft 2020-12) of a case file."""
    schema = CaseTable.model_json_schema(by_alias=True)
    tables = schema["$defs"]
    tables["SectionTable"] = SectionTable.model_json_schema(by_alias=True)
    tables["QuestionTable"] = QuestionTable.model_json_schema(by_alias=True)
    models = all_models().values()
    _fill_model(tables["ModelTable"], models)
    _fill_friction(tables["FrictionTable"])
    _fill_analysis(tables["AnalysisTable"], all_analyses().values())
    _fill_grid(schema["properties"]["grid"], models)
    _fill_schedule(schema["properties"]["schedule"], models)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _fill_model(table: Schema, models: Iterable[Model]) -> None:
    names = {model.name: model.title for model in models}
    table["properties"]["name"]["enum"] = list(names)
    table["allOf"] = [_when("name", model.name, _of_model(model)) for model in models]


def _of_model(model: Model) -> Schema:
    options = {option.name: _option(option) for option in model.options}
    return {
        "parameters": {
            "properties": _parameters(model.parameters),
            "patternProperties": _GREEK_SPELLINGS,
            "additionalProperties": False,
        },
        "options": {"properties": options, "additionalProperties": False},
    }


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
        _when("kind", analysis.kind, _settings(analysis), _required(analysis))
        for analysis in analyses
    ]


def _settings(analysis: Analysis) -> Schema:
    return {setting.name: _setting(setting) for setting in analysis.settings}


def _required(analysis: Analysis) -> list[str]:
    return [setting.name for setting in analysis.settings if setting.required]


def _setting(setting: Setting) -> Schema:
    forms: Mapping[str, Schema] = {
        "number": QUANTITY_SCHEMA,
        "integer": {"type": "integer"},
        "string": {"type": "string"},
        "boolean": {"type": "boolean"},
        "section": {"$ref": "#/$defs/SectionTable"},
        "state": {"type": "string"},
        "parameter": {"type": "string"},
        "bracket": INTERVAL_SCHEMA,
        "points": {"type": "array", "items": INTERVAL_SCHEMA},
        "question": {"$ref": "#/$defs/QuestionTable"},
    }
    unit = "" if setting.unit == "1" else f" ({setting.unit})"
    form = {**forms[setting.type], "description": f"{setting.meaning}{unit}"}
    return {**form, "enum": list(setting.choices)} if setting.choices else form


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


def _when(key: str, value: str, properties: Schema, required: Sequence[str] = ()) -> Schema:
    """Where `key` is `value`, the table has these properties."""
    then: Schema = {"properties": properties}
    if required:
        then["required"] = list(required)
    return {"if": {"properties": {key: {"const": value}}, "required": [key]}, "then": then}
