"""A case file to start from: a sweep in which the model vibrates, with all else in comments.

What stands behind ``#`` at the beginning of a line may be taken in as it stands, with the lines
below it that stand behind ``#   ``; what stands behind ``##``, in place of all that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from fiv_cli.analyses.base import Analysis
from fiv_cli.analyses.catalogue import ALL_ASKED, variables_of
from fiv_cli.analyses.settings import ParameterName, Setting
from fiv_cli.analyses.variables import Role, Variable
from fiv_cli.case.excitation import forced
from fiv_cli.case.structure import ForceTable
from fiv_cli.case.toml import toml_value
from fiv_cli.flags import TABLES
from fiv_cli.friction import TANH_OF, get_law, laws_of
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Example, Model, Parameter
from fiv_cli.notation.names import listed

# Parameters worth a first sweep where no motion is followed, the best first.
_SWEPT_FIRST = ("mu_k", "mu_0", "F0", "v", "Omega")
_AT_REST = ("equilibrium", "eigenvalues", "critical")
_CLAIMED = ("periodic", "stable", "to_unstable")
_POINTS, _SMOOTH = 7, 41  # of an axis: where motions are followed, and where the points are cheap
_WINDOWS = 40.0  # over a resolution: how long a drive slows down, ten windows of a spectrogram
_COMMENT_COLUMN = 34
_HOW_TO_READ = (
    "to take in what stands behind a #, remove it, and that of the lines indented below; "
    "of lines behind ## take in one"
)
_AXES = "ordered; ends included; a list, or step = instead of num ="


def case_template(model: Model, analysis: Analysis) -> str:
    """TOML text of a case of `model` and `analysis`, valid as it stands."""
    return "\n\n".join("\n".join(block) for block in _Template.of(model, analysis).blocks()) + "\n"


@dataclass(frozen=True)
class _Template:
    """What a case begins with.

    Attributes
    ----------
    example : where the model vibrates; of what is swept first: its range
    axis : what the grid varies; None: nothing
    second : what it could vary besides; None: nothing
    varied : what an analysis varies itself, or what a grid could vary
    drive : what may vary in time; None: nothing
    """

    model: Model
    analysis: Analysis
    law: Law
    example: Example
    axis: Parameter | None
    second: Parameter | None
    varied: Parameter
    drive: Parameter | None

    @classmethod
    def of(cls, model: Model, analysis: Analysis) -> _Template:
        """The template of a model and an analysis."""
        own = (model.sliding if analysis.linear else None) or model.example
        law = get_law((own.law if own else "") or model.default_law)
        known = {p.name: p for p in model.parameters_under(law)}
        example = own or _example(known)
        first = known.pop(example.axis)
        others = [known[name] for name in _SWEPT_FIRST if name in known] or list(known.values())
        found = [setting for setting in analysis.settings if isinstance(setting, ParameterName)]
        finds = any(setting.required for setting in found)  # where along the first it changes
        axis = None if analysis.single else others[0] if finds else first
        varied = others[0] if found and not finds else first
        drive = _drive(model, first if analysis.constant else axis) or others[0]
        if analysis.single and analysis.uses_starts and (analysis.constant or drive != first):
            example = replace(example, given={**example.given, first.name: example.middle})
        varying = drive if analysis.varying else None
        apart = (first, axis, varied, varying)
        more = [*others, *(p for p in model.parameters if p.role), *model.parameters]
        second = next((p for p in more if axis is not None and p not in apart), None)
        return cls(model, analysis, law, example, axis, second, varied, varying)

    def blocks(self) -> Iterable[list[str]]:
        """The tables in order."""
        yield self.header()
        yield self.of_model()
        if self.model.contacts:
            yield self.friction()
        if self.drive is not None:
            yield self.schedule(self.drive)
        if forced(self.model):
            yield self.forcing()
        if self.axis is not None:
            yield self.grid(self.axis)
        if self.analysis.uses_starts:
            yield from self.starts()
        yield self.settings()
        yield self.figure()
        yield self.claim()
        yield _solver()

    def header(self) -> list[str]:
        return [
            _with_comment("schema = 1", _HOW_TO_READ),
            f'title = "{self.model.title}: {self.analysis.title}"',
            '# reference = "the publication"',
            '# assumed = ["what the publication leaves open and this case chose"]',
        ]

    def of_model(self) -> list[str]:
        lines = ["[model]", f'name = "{self.model.name}"', ""]
        lines += [_with_comment("[model.parameters]", 'in SI, or with a unit: "20 rpm", "15 deg"')]
        lines += self.parameters(self.model.parameters)
        if self.model.options:
            lines += ["", "[model.options]"]
        for option in self.model.options:
            choices = option.form or " | ".join(option.choices)
            line = self.given(option.name, option.default)
            lines.append(_with_comment(line, f"{option.meaning}: {choices}"))
        return lines

    def friction(self) -> list[str]:
        known = laws_of(self.model)
        others = [name for name in known if name != self.law.name and not name.startswith(TANH_OF)]
        smooth = (
            ["tanh (with of = one of these)"] if any(n.startswith(TANH_OF) for n in known) else []
        )
        head = _with_comment(f'law = "{self.law.name}"', f"or {listed([*others, *smooth])}")
        table = "[friction]"
        if others:
            axis = f"friction = {toml_value([self.law.name, others[0]], 'friction')}"
            table = _with_comment(table, f"several laws: {axis} under [grid], and no law here")
        return [table, head, *self.parameters(self.model.adopted(self.law))]

    def parameters(self, table: Iterable[Parameter]) -> list[str]:
        """A line for each parameter that neither the grid nor a schedule gives."""
        elsewhere = [p.name for p in (self.axis, self.drive) if p is not None]
        values = {p.name: p.default for p in self.model.parameters_under(self.law)}
        values[self.example.axis] = self.example.high
        if self.drive is not None:
            values[self.drive.name] = self.beginning(self.drive)
        lines = []
        for p in table:
            leader = p.default_from or ""
            follows = f"; left out, that of {leader}" if leader else ""
            line = self.given(p.name, values[leader] if leader else p.default)
            lines += [_with_comment(line, _about(p) + follows)] * (p.name not in elsewhere)
        return lines

    def given(self, name: str, default: object) -> str:
        """The line of a parameter or an option: as the example has it, else as a comment."""
        mark = "" if name in self.example.given else "# "
        return f"{mark}{name} = {toml_value(self.example.given.get(name, default), name)}"

    def schedule(self, drive: Parameter) -> list[str]:
        """The drive slowing down; of an analysis that needs no such thing, in comments."""
        stop, start = self.range_of(drive)[0], self.beginning(drive)
        over = _WINDOWS / self.example.settings.get("resolution", 0.01)
        line = f"{drive.name} = {{ start = {start!r}, stop = {stop!r}, over = {over!r} }}"
        head = _with_comment("[schedule]", "what varies in time; or points = [[t, value], ...]")
        if not self.analysis.constant:
            return [head, line]
        constant = f"constant: {drive.name} = {start!r} under [model.parameters]"
        return _commented([head, _with_comment(line, constant)])

    def forcing(self) -> list[str]:
        """An external force and, where nothing else varies, a parameter that does; in comments."""
        name, meaning = next(iter(forced(self.model).items()))
        others = [other for other in forced(self.model) if other != name]
        head = _with_comment("[forcing]", f"external forces; also on {listed(others)}")
        force = _commented([head, _with_comment(f"{name} = {ForceTable.example}", meaning)])
        speed = next((p for p in self.model.parameters if p.role == "speed"), None)
        if self.drive is not None or speed is None:
            return force
        head = _with_comment("[schedule]", "a parameter that swings; A_, omega_ and phase_ of it")
        amplitude = f"amplitude = {0.1 * (speed.default or 1.0):g}"
        swing = f"{speed.name} = {{ {amplitude}, omega = 0.8, phase = 0.0 }}"
        return [*force, "", *_commented([head, _with_comment(swing, "may be axes, too")])]

    def beginning(self, drive: Parameter) -> float:
        """Where the drive begins to slow down."""
        own = drive.name == self.example.axis
        return self.example.middle if own else self.range_of(drive)[1]

    def grid(self, axis: Parameter) -> list[str]:
        """An axis; one more behind ##, along which it may be zipped; and what may be refined."""
        lines = [_with_comment("[grid]", _AXES), self.over(axis, _about(axis)), "", "[sweep]"]
        if self.second is not None:
            map_of_both = self.over(self.second, "a second axis: a map")
            lines.insert(2, _behind("## ", map_of_both))
            pair = toml_value([[axis.name, self.second.name]], "zip")
            line = _with_comment(f"zip = {pair}", "with that line: both together, no map")
            lines.append(_behind("##   ", line))
        told = next((v.name for v in self.variables() if v.is_class and not v.ragged), None)
        if told is not None:
            refine = f'refine = {{ levels = 2, of = "{told}" }}'
            only = "more points where the class changes, not along what a start follows"
            lines.append(_behind("## ", _with_comment(refine, only)))
        return lines

    def over(self, axis: Parameter, comment: str) -> str:
        """The line of an axis."""
        low, high = self.range_of(axis)
        points = _SMOOTH if self.analysis.kind in _AT_REST else _POINTS
        line = f"{axis.name} = {{ start = {low!r}, stop = {high!r}, num = {points} }}"
        return _with_comment(line, comment)

    def range_of(self, parameter: Parameter) -> tuple[float, float]:
        """Where a parameter is varied."""
        if parameter.name == self.example.axis:
            return self.example.low, self.example.high
        size = parameter.default or 1.0
        return size / 2, size

    def starts(self) -> Iterable[list[str]]:
        """One at rest, and one of each other kind behind #."""
        state = self.model.states(self.model.default_options())[0]
        moved = f"state = {{ {state.name} = 1e-3 }}"
        yield [
            _with_comment("[[initial]]", "where a motion starts; more of these: more starts"),
            'label = "rest"',
            'kind = "state"',
            _with_comment(f"# {moved}", f"what is not 0, in {state.unit}; or a parameter's name"),
        ]
        offset = f"offset = {{ {state.name} = 1e-3 }}"
        near = ['label = "near"', 'kind = "equilibrium"', _with_comment(offset, "from it")]
        box = f"box = {{ {state.name} = [-1e-3, 1e-3] }}"
        many = ['label = "many"', 'kind = "random"', "count = 3", _with_comment(box, "in it")]
        yield _commented([_with_comment("[[initial]]", "at a sliding equilibrium, moved"), *near])
        yield _commented([_with_comment("[[initial]]", "random states, seeded"), *many])
        listed = f"states = [{{ {state.name} = 1e-3 }}, {{ {state.name} = 2e-3 }}]"
        listed = _with_comment(listed, 'or file = "starts.csv"')
        table = ['label = "listed"', 'kind = "table"', listed]
        yield _commented([_with_comment("[[initial]]", "states from a list, or a file"), *table])
        if self.axis is not None and self.analysis.chains:
            down = [f'along = "{self.axis.name}"', 'direction = "down"', 'from = "rest"']
            head = _with_comment("[[initial]]", "where the neighbour on the axis ended")
            after = _with_comment('on_loss = "go-on"', "or stop, restart: where its class is lost")
            steps = _with_comment('steps = "shorter"', "or grid, of which one may lose it early")
            lines = [head, 'label = "down"', 'kind = "continue"', *down, after, steps]
            yield _commented(lines)

    def settings(self) -> list[str]:
        lines, shown = ["[[analysis]]", f'kind = "{self.analysis.kind}"'], set()
        for setting in self.analysis.settings:
            given = setting.required or self.is_given(setting)
            mark = "" if given else "#   " if setting.partner in shown else "# "
            if setting.suits(self.model):
                lines.append(_behind(mark, self.setting(setting)))
                shown.add(setting.name)
        return lines

    def is_given(self, setting: Setting) -> bool:
        """Whether the example says what a setting is that has a value in any case."""
        known = setting.required or setting.default is not None
        return known and setting.name in self.example.settings

    def setting(self, setting: Setting) -> str:
        """A setting as the example has it, else with its default or a sample."""
        name = setting.name
        own: dict[str, Any] = {"bracket": list(self.range_of(self.varied))}
        own |= self.example.settings if self.is_given(setting) else {}
        shown = toml_value(own[name], name) if name in own else None
        line = f"{name} = {shown or setting.example(self.model, self.varied)}"
        return _with_comment(line, setting.description)

    def figure(self) -> list[str]:
        shown = f'kind = "{self.analysis.figure}"'
        lines = [
            _with_comment("[[figure]]", "what `fiv plot` draws; `fiv kinds` lists more"),
            shown,
        ]
        lines += ['# name = "first"', '# title = "over the figure"']
        if self.analysis.uses_starts:
            lines.append(_with_comment('# select = { initial = "rest" }', "axis -> what is drawn"))
        if self.axis is None:
            return lines
        low, high = self.range_of(self.axis)
        shown = f"# xlim = {toml_value([low, high], 'xlim')}"
        return [*lines, f'x = "{self.axis.name}"', shown, '# log = "x"']

    def claim(self) -> list[str]:
        variable = _telling(self.variables())
        classes = [] if not variable.flags else list(TABLES[variable.flags].codes)
        said = next((name for name in classes if name in _CLAIMED), "above 0")
        expected = f'"{said}"' if classes else "{ greater_than = 0.0 }"
        at = [] if self.axis is None else [f'at = {{ {self.axis.name} = ". > 0" }}']
        return _commented(
            [
                _with_comment("[[claim]]", "what the publication says; `fiv kinds claim`"),
                'source = "its section or figure"',
                f'text = "{variable.long_name}: {said}"',
                _with_comment(f'variable = "{variable.name}"', "`fiv variables CASE` lists them"),
                *(_with_comment(line, "where; left out: everywhere") for line in at),
                f"expect = {expected}",
            ]
        )

    def variables(self) -> Iterable[Variable]:
        """What the analysis gives."""
        options = self.model.default_options()
        return variables_of(self.analysis.kind, self.model, options, ALL_ASKED)


def _drive(model: Model, other: Parameter | None) -> Parameter | None:
    """What drives a model, or else presses on it, and is not the `other`."""
    driving = [p for role in ("speed", "preload") for p in model.parameters if p.role == role]
    return next((p for p in driving if p != other), None)


def _telling(variables: Iterable[Variable]) -> Variable:
    """The variable that a claim is likely to be about."""
    answers = [v for v in variables if v.role in (Role.ANSWER, Role.CLASS) and not v.ragged]
    classes = [v for v in answers if v.headline and v.flags]
    return next(iter([*classes, *(v for v in answers if v.headline), *answers]))


def _example(known: Mapping[str, Parameter]) -> Example:
    """Of a model that has none: what is worth a first sweep."""
    axis = known[next((name for name in _SWEPT_FIRST if name in known), next(iter(known)))]
    return Example(axis.name, (axis.default or 1.0) / 2, axis.default or 1.0)


def _solver() -> list[str]:
    method = _with_comment('method = "taylor"', 'adaptive; or "rk4", with its step in s')
    return _commented(["[solver]", method, "rtol = 1e-9", "max_events = 1000000"])


def _commented(lines: list[str]) -> list[str]:
    """Lines that belong together, behind #."""
    head, *below = lines
    return [_behind("# ", head), *(_behind("#   ", line) for line in below)]


def _behind(mark: str, line: str) -> str:
    """A line behind a mark, its comment where that of others is."""
    head, gap, comment = line.partition("  # ")
    return _with_comment(mark + head.rstrip(), comment) if gap else mark + line


def _about(parameter: Parameter) -> str:
    return parameter.meaning + ("" if parameter.unit == "1" else f" ({parameter.unit})")


def _with_comment(line: str, comment: str) -> str:
    return f"{line}  ".ljust(_COMMENT_COLUMN) + f"# {comment}"
