"""A case file to start from: valid as it stands, with everything else in comments."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.catalogue import possible_variables
from fiv_cli.analyses.settings import ParameterName, Setting
from fiv_cli.analyses.variables import Role
from fiv_cli.friction import get_law, laws_of
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Model, Parameter

# Parameters worth a first sweep, the best first.
_SWEPT_FIRST = ("mu_k", "mu_0", "F0", "v", "Omega")
_DRIVES = ("Omega", "v")
_COMMENT_COLUMN = 34


def case_template(model: Model, analysis: Analysis) -> str:
    """TOML text of a case of `model` and `analysis`.

    What is required is set, the rest is there with its default behind a ``#``. There is a grid
    of a few points, but where one motion or one plate says something.
    """
    law = get_law(model.default_law)
    first, second, *_ = _swept(model, law)
    varies = any(isinstance(setting, ParameterName) for setting in analysis.settings)
    axis = None if analysis.single else second if varies else first
    drive = _drive(model, axis) if analysis.varying else None
    taken = {p.name for p in (axis, None if analysis.constant else drive) if p is not None}
    blocks = [
        _header(model, analysis),
        _model(model, taken),
        _friction(model, law, taken) if model.contacts else [],
        [] if drive is None else _schedule(drive, "# " * analysis.constant),
        _grid(axis, first),
        [] if axis is None else _sweep(analysis),
        _starts(model) if analysis.uses_starts else [],
        _analysis(model, analysis, first),
        _figure(analysis, axis),
        _claim(),
        _solver(),
    ]
    return "\n\n".join("\n".join(block) for block in blocks if block) + "\n"


def _header(model: Model, analysis: Analysis) -> list[str]:
    return [
        "schema = 1",
        f'title = "{model.title}: {analysis.title}"',
        '# reference = "Figure 7.6"',
        '# assumed = ["what the publication leaves open and this case chose"]',
    ]


def _model(model: Model, taken: Collection[str]) -> list[str]:
    lines = ["[model]", f'name = "{model.name}"', ""]
    lines += [_with_comment("[model.parameters]", 'in SI, or with a unit: "20 rpm", "15 deg"')]
    lines += _parameters(model.parameters, taken)
    if model.options:
        lines += ["", "[model.options]"]
    for option in model.options:
        choices = option.form or " | ".join(option.choices)
        line = f'# {option.name} = "{option.default}"'
        lines.append(_with_comment(line, f"{option.meaning}: {choices}"))
    return lines


def _friction(model: Model, law: Law, taken: Collection[str]) -> list[str]:
    others = ", ".join(name for name in laws_of(model) if name != law.name)
    line = f'law = "{law.name}"'
    head = _with_comment(line, f"or {others}") if others else line
    return ["[friction]", head, *_parameters(model.adopted(law.parameters), taken)]


def _parameters(parameters: Iterable[Parameter], taken: Collection[str]) -> list[str]:
    """One commented line for each parameter that the case does not give elsewhere."""
    return [
        _with_comment(f"# {p.name} = {_default(p)}", f"{p.meaning}{_unit(p.unit)}")
        for p in parameters
        if p.name not in taken
    ]


def _default(parameter: Parameter) -> str:
    value = parameter.default
    return f"# the value of {parameter.default_from}" if value is None else repr(value)


def _grid(axis: Parameter | None, example: Parameter) -> list[str]:
    shown = axis or example
    high = shown.default or 1.0
    line = f"{shown.name} = {{ start = {high / 2!r}, stop = {high!r}, num = 5 }}"
    if axis is None:
        return ["# [grid]", f"#   {line}"]
    return [
        _with_comment("[grid]", "ordered; ends included; a list, or step = instead of num ="),
        _with_comment(line, f"{axis.meaning}{_unit(axis.unit)}"),
    ]


def _sweep(analysis: Analysis) -> list[str]:
    """How a grid is refined, where the analysis has a class whose borders can be followed."""
    classes = [v for v in possible_variables(analysis) if v.role is Role.CLASS]
    of = next((v.name for v in classes if v.headline), None)
    if of is None:
        return []
    line = f'# refine = {{ levels = 5, of = "{of}" }}'
    return [
        "# [sweep]",
        _with_comment(line, "halve the grid so often, along borders of classes only"),
    ]


def _drive(model: Model, axis: Parameter | None) -> Parameter | None:
    """What drives the model; None where that is the axis, or nothing does."""
    return next((p for p in model.parameters if p.name in _DRIVES and p != axis), None)


def _schedule(drive: Parameter, mark: str) -> list[str]:
    """The drive slowing down."""
    start = drive.default or 1.0
    line = f"{drive.name} = {{ start = {start!r}, stop = {start / 2!r}, over = 20.0 }}"
    said = "parameters that vary in time; points = [[t, value], ...]"
    return [_with_comment(f"{mark}[schedule]", said), f"{mark and '#   '}{line}"]


def _swept(model: Model, law: Law) -> list[Parameter]:
    """The parameters, those worth a sweep first."""
    known = {p.name: p for p in model.parameters_under(law.parameters)}
    first = [name for name in _SWEPT_FIRST if name in known]
    return [known[name] for name in dict.fromkeys([*first, *known])]


def _starts(model: Model) -> list[str]:
    state = model.states(model.default_options())[0]
    return [
        _with_comment("[[initial]]", "where a motion starts; more of these: more starts"),
        'label = "near"',
        _with_comment('kind = "equilibrium"', "of the unexcited system, plus the offset"),
        _with_comment(f"offset = {{ {state.name} = 1e-4 }}", state.unit),
    ]


def _analysis(model: Model, analysis: Analysis, varied: Parameter) -> list[str]:
    lines = ["[[analysis]]", f'kind = "{analysis.kind}"']
    suited = [setting for setting in analysis.settings if setting.suits(model)]
    return lines + [_setting(model, setting, varied) for setting in suited]


def _setting(model: Model, setting: Setting, varied: Parameter) -> str:
    line = f"{setting.name} = {setting.example(model, varied)}"
    return _with_comment(line if setting.required else f"# {line}", setting.description)


def _figure(analysis: Analysis, axis: Parameter | None) -> list[str]:
    shown = f'kind = "{analysis.figure}"'
    lines = [_with_comment("[[figure]]", "what `fiv plot` draws"), shown]
    return lines if axis is None else [*lines, f'x = "{axis.name}"']


def _claim() -> list[str]:
    return [
        _with_comment("# [[claim]]", "what the publication says, checked by `fiv claims`"),
        '# source = "7.3, Figure 7.6"',
        '# text = "the response is periodic"',
        '# variable = "attractor"',
        '# expect = "periodic"',
    ]


def _solver() -> list[str]:
    return [
        "# [solver]",
        _with_comment('# method = "taylor"', 'adaptive; or "rk4", with its step in s'),
        "# rtol = 1e-9",
    ]


def _unit(unit: str) -> str:
    return "" if unit == "1" else f" ({unit})"


def _with_comment(line: str, comment: str) -> str:
    return f"{line}  ".ljust(_COMMENT_COLUMN) + f"# {comment}"
