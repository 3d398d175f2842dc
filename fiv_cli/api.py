"""fiv from Python: the steps of the commands as functions, for notebooks and programs.

>>> from fiv_cli import api
>>> case = api.load(
...     {
...         "schema": 1,
...         "model": {"name": "belt-1dof"},
...         "grid": {"v": [0.5, 1.0]},
...         "analysis": [{"kind": "response"}],
...     }
... )
>>> found = api.run(case)
>>> api.names_of(found["attractor"]).values.ravel().tolist()
['periodic', 'periodic']

What goes wrong is one of the exceptions of `fiv_cli.errors`, all of them a `FivError`, with the
text that the command would print.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import RLock
from typing import TYPE_CHECKING, Any

from fiv_cli.errors import CaseError, FivError, Problem, UsageError
from fiv_cli.notation.names import pick

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from fiv_cli.analyses.base import Analysis, Outcome, SolverSettings, Start
    from fiv_cli.case.case import Case
    from fiv_cli.codegen.setup import Setup
    from fiv_cli.friction.base import Law
    from fiv_cli.models.base import Model
    from fiv_cli.reading.claims import Verdict
    from fiv_cli.reading.compare import Difference
    from fiv_cli.sweep.plan import Plan
    from fiv_cli.sweep.progress import Progress

    Results = xr.Dataset | xr.DataTree

__all__ = [
    "CaseError",
    "FivError",
    "UsageError",
    "analyse",
    "check",
    "claims",
    "diff",
    "figure",
    "history",
    "join",
    "load",
    "names_of",
    "observations",
    "read",
    "run",
]


_ALONE = RLock()
"""Libraries below (those that write NetCDF, say) bear no second thread."""


def load(
    source: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | Sequence[str] = (),
    using: str | Path | Sequence[str | Path] | None = None,
) -> Case:
    """The case in a file, or of the tables that such a file would hold.

    Parameters
    ----------
    source : path of a TOML file; or its tables: dicts, lists, numbers (or arrays) and texts
    overrides : what is changed: dotted path -> value; or the lines of ``fiv run --set``
    using : files of models and laws that are not in the box, as ``fiv run --with`` takes them;
        None: those of the last call that named any

    Raises
    ------
    CaseError
        something in it is wrong; its `problems` are all of its form; where that is right, all
        names that are not known; where there are none, all that is wrong with values.
    UsageError
        there is no such file, or an override names nothing.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "response"}]}
    >>> api.load(belt, overrides={"grid.v": [0.5, 1.0]}).axis("v").values
    (0.5, 1.0)
    >>> api.load(belt, overrides={"model.parameters.mass": 2.0})
    Traceback (most recent call last):
        ...
    fiv_cli.errors.CaseError: <dict>: 1 problem; nothing was computed
    ...
    """
    from fiv_cli.case.load import load_case, parse_case
    from fiv_cli.case.toml import DICT, toml_text, toml_value

    if using is not None:
        from fiv_cli.own.probe import use_files

        use_files([Path(using)] if isinstance(using, str | Path) else map(Path, using))
    if isinstance(overrides, Mapping):
        overrides = [f"{path}={toml_value(value, path)}" for path, value in overrides.items()]
    if not isinstance(source, Mapping):
        return load_case(source, overrides)
    try:
        return parse_case(toml_text(source), DICT, overrides)
    except RecursionError:
        problem = Problem("case", "nests too deeply")
        raise CaseError(DICT, [problem]) from None
    except CaseError as error:  # a dict has no lines
        problems = [replace(problem, line=None, column=None) for problem in error.problems]
        raise CaseError(DICT, problems) from None


def check(case: Case) -> Plan:
    """What `run` will do with a case: its points, its chains, and what is left out.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "response"}]}
    >>> plan = api.check(api.load(belt, overrides={"grid.mu_k": [0.2, 0.3, 0.5]}))
    >>> plan.size
    3
    >>> print(plan)
    <dict>
      model belt-1dof, friction coulomb
      by default, in SI: N = 10, v = 1, u0 = 0, omega = 1, mu_s = 0.4, 3 more: fiv models belt-1dof
      mu_s: the default of belt-1dof, not of the law
      response: 3 points (mu_k 3 x initial 1)
        mu_k = 0.2, 0.3, 0.5
        1 point where mu_k is above mu_s will not be computed
    """
    from fiv_cli.sweep.plan import make_plan

    return make_plan(_loaded(case))


def run(
    case: Case,
    output: str | Path | None = None,
    *,
    workers: int = 2,
    fresh: bool = False,
    progress: bool | Progress = False,
) -> Results:
    """Compute every point of a case.

    Parameters
    ----------
    output : dataset to write; what is finished is kept beside it, so that the same call goes on
        where it was interrupted. None: nothing is kept
    workers : worker processes; 1: in this process
    fresh : throw away what is stored at `output`
    progress : whether to tell stderr how far it is; or an object that is told, with the methods of
        `fiv_cli.sweep.progress.Progress`

    Returns
    -------
    the dataset; of several analyses a tree with a dataset for each, by name. Whether and why a
    point has no answer stands in its ``status`` and ``reason``

    Raises
    ------
    UsageError, StorageError
        `output` cannot be written, or nobody is to compute.
    StoreMismatchError, LockedError
        another case is stored there, or is running there.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "equilibrium"}]}
    >>> found = api.run(api.load(belt, overrides={"grid.mu_k": [0.1, 0.2]}))
    >>> found["equilibrium"].sel(state="x").values.ravel().tolist()
    [1.0, 2.0]
    """
    from fiv_cli.sweep.policy import Policy
    from fiv_cli.sweep.progress import for_stderr
    from fiv_cli.sweep.run import run_case

    if workers < 1:
        raise UsageError(f"workers={workers}: nobody computes\nnext: workers=1, in this process")
    told = for_stderr(quiet=not progress) if isinstance(progress, bool) else progress
    with _computing(), _place(output) as path:
        policy = Policy(workers=workers, fresh=fresh, foresee=bool(progress))
        run_case(_loaded(case), path, policy, told)
        return read(path)


def history(
    case: Case,
    at: Mapping[str, Any] | None = None,
    *,
    t_end: float | str | None = None,
    sample: float | str | None = None,
    periods: float | None = None,
    settled: bool = False,
    output: str | Path | None = None,
) -> xr.Dataset:
    """The full motion of one point of a case: states, forces, events.

    Parameters
    ----------
    at : the point: axis -> value, and ``initial`` -> label; what has one value may be left out
    t_end, sample : end of the motion and interval of its samples, s (or ``"2 min"``); None: as
        the case has it
    periods : of the steady state; the motion ends after so many, instead of at t_end
    settled : begin where the steady state is reached
    output : dataset to write, if any

    Raises
    ------
    UsageError
        there is no such point, or it is not computed.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "response"}]}
    >>> case = api.load(belt, overrides={"grid.v": [0.5, 1.0]})
    >>> motion = api.history(case, at={"v": 1.0}, t_end=20.0)
    >>> round(float(motion["x"].max()), 3)
    4.272
    >>> api.history(case, at={"w": 1.0})
    Traceback (most recent call last):
        ...
    fiv_cli.errors.UsageError: --at w: no axis of this case
    next: choose from v, initial
    """
    from fiv_cli.reading.datasets import read_analyses
    from fiv_cli.sweep.motion import find_point, motion_settings, steady_part, write_motion

    point = find_point(_loaded(case), {name: str(value) for name, value in (at or {}).items()})
    settings, steady = motion_settings(t_end, sample), steady_part(periods, settled, t_end)
    with _computing(), _place(output) as path:
        write_motion(point, settings, path, lambda sentence: None, steady)
        (dataset,) = read_analyses(path).values()
        return dataset


def read(path: str | Path) -> Results:
    """The dataset that a run has written.

    Returns
    -------
    xarray.Dataset or xarray.DataTree
        of several analyses a tree of them: ``api.read("runs/a.nc")["spectrum"]`` is one, with its
        variables, and ``[*api.read("runs/a.nc").children]`` names all.

    Raises
    ------
    UsageError, InputError
        there is no such file; it is none that fiv wrote, or is damaged.

    Examples
    --------
    >>> from fiv_cli import api
    >>> api.read("nowhere.nc")
    Traceback (most recent call last):
        ...
    fiv_cli.errors.UsageError: nowhere.nc: no such file
    next: name a dataset written by `fiv run`
    """
    from fiv_cli.reading.datasets import read_analyses

    with _ALONE:
        return _results_of(read_analyses(path))


def join(runs: Sequence[str | Path | Results], along: str) -> Results:
    """Several runs as one dataset, as one run of all their points would have it.

    Where no run has a point of the grid of all, it is ``pending``.

    Parameters
    ----------
    runs : what `run`, `history` or `read` returned, or paths of datasets
    along : an axis of the grid, or a parameter that each run had another value of

    Raises
    ------
    UsageError
        a run has no such parameter, two have the same value of it, or they are of different
        analyses.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "response"}]}
    >>> case = belt | {"grid": {"v": [0.5, 1.0]}}
    >>> runs = [api.run(api.load(case, {"model.parameters.N": N})) for N in (5.0, 10.0)]
    >>> both = api.join(runs, "N")
    >>> dict(both["attractor"].sizes)
    {'N': 2, 'v': 2, 'initial': 1}
    >>> api.observations(both, "section_value").groupby("N").mean().values.round(3).tolist()
    [0.3, 0.6]
    """
    from fiv_cli.reading.join import joined

    each = [_analyses_of(run) for run in ([runs] if isinstance(runs, str | Path) else runs)]
    names = {*each[0]} if each else set()
    if not names or any({*one} != names for one in each):
        raise UsageError("runs of different analyses, or none\nnext: join runs of one case")
    return _results_of({name: joined([one[name] for one in each], along) for name in each[0]})


def _results_of(analyses: Mapping[str, xr.Dataset]) -> Results:
    """The dataset of one analysis, or a tree of several."""
    if len(analyses) > 1:
        from xarray import DataTree

        return DataTree.from_dict(analyses)
    (dataset,) = analyses.values()
    return dataset


def diff(
    first: str | Path | Results,
    second: str | Path | Results,
    tolerances: str | Path | None = None,
) -> list[Difference]:
    """What `fiv diff` finds between two datasets; [] where they agree.

    Parameters
    ----------
    first, second : what `run`, `history` or `read` returned, or paths of datasets
    tolerances : TOML file, as of ``fiv diff --tolerances``

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "response"}]}
    >>> free, damped = (api.run(api.load(belt, {"model.parameters.c": c})) for c in (0.0, 2.0))
    >>> print(api.diff(free, free), api.diff(free, damped)[0].text)
    [] periodic -> equilibrium 1 at the only point
    """
    from fiv_cli.reading.compare import Tolerances, compare, read_tolerances

    chosen = Tolerances() if tolerances is None else read_tolerances(Path(tolerances))
    return compare(_analyses_of(first), _analyses_of(second), chosen)


def names_of(flags: xr.DataArray) -> xr.DataArray:
    """A variable of flags (``attractor``, ``status``, ``contact_state``) in words; of NaN, "".

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "eigenvalues"}]}
    >>> found = api.run(api.load(belt, overrides={"grid.c": [0.0, 0.1]}))
    >>> api.names_of(found["stable"]).values.tolist()
    ['neutral', 'stable']
    """
    from xarray import apply_ufunc

    from fiv_cli.reading.datasets import flag_names

    names = flag_names(flags.attrs)
    if not names:
        raise UsageError(f"{flags.name}: holds numbers, not classes\nnext: take its values")
    return apply_ufunc(lambda code: names.get(code, ""), flags, vectorize=True, output_dtypes=[str])


def observations(data: str | Path | Results, variable: str, **at: Any) -> xr.DataArray:
    """The values of a variable with any number of them per point, each with its point's axes.

    Parameters
    ----------
    data : what `run`, `history`, `read` or `join` returned, or the path of a dataset; of several
        analyses that one is meant which has the variable
    variable : ``section_value``, say
    at : which points: axis -> value, label, condition (``". > 2"``), or a list of these; a part
        of the dataset is refused, for the values do not follow its points

    Raises
    ------
    UsageError
        no analysis has such a variable, or several have; there is no such axis or value.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "response"}]}
    >>> found = api.run(api.load(belt, overrides={"grid.N": [5.0, 10.0]}))
    >>> api.observations(found, "section_value").groupby("N").mean().values.round(3).tolist()
    [0.3, 0.6]
    >>> api.observations(found, "section_value", N=10.0).values.round(3).tolist()
    [0.6]
    """
    from fiv_cli.reading import select

    analyses = _analyses_of(data)
    holding = [name for name, dataset in analyses.items() if variable in dataset]
    if len(holding) > 1:
        raise UsageError(
            f"{variable}: in several analyses, {', '.join(holding)}\n"
            f'next: api.observations(api.read(...)["{holding[0]}"], "{variable}")'
        )
    richest = max(analyses, key=lambda name: len(select.ragged_dims(analyses[name])))
    return select.observations(analyses[(holding or [richest])[0]], variable, at)


def figure(
    data: str | Path | Results,
    name: str | None = None,
    axis: Axes | None = None,
    *,
    style: str = "screen",
    width: float | None = None,
    height: float | None = None,
    font: str | None = None,
    title: bool | None = None,
) -> Figure:
    """Draw a dataset; a notebook that has imported matplotlib.pyplot shows what is returned.

    What is added to it afterwards has matplotlib's own fonts: a legend that of
    ``prop=drawn.axes[0].xaxis.label.get_fontproperties()``.

    Parameters
    ----------
    data : what `run`, `history` or `read` returned, or the path of a dataset
    name : a figure of the case, or a kind of figure; None: the first that suits
    axis : where to draw a figure of one panel; None: on a figure of its own
    style : what it is for: "screen", "paper" or "talk"
    width, height, font, title : in place of those of the style: mm, a family that is installed,
        whether there is one

    Raises
    ------
    UsageError
        the dataset does not hold what the figure shows, or there is no such figure.

    Examples
    --------
    >>> from fiv_cli import api
    >>> belt = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "equilibrium"}]}
    >>> found = api.run(api.load(belt, overrides={"grid.mu_k": [0.1, 0.2, 0.3]}))
    >>> drawn = api.figure(found)
    >>> drawn.axes[0].get_ylabel()
    'sliding equilibria with closed contacts'
    """
    from fiv_cli.plots import draw, figures_called, look_of, nothing_suits, possible_figures

    source = _readable(data)
    chosen = possible_figures(source) if name is None else figures_called(source, name)
    if not chosen:
        raise nothing_suits(source)
    return draw(source, chosen[0], axis, look_of(style, width, font, title, height))


def claims(case: Case, data: str | Path | Results | None = None) -> list[Verdict]:
    """The verdict of each claim of a case, as `fiv claims` has them.

    Parameters
    ----------
    data : what `run` or `read` returned for the case, or the path of its dataset; None: the
        dataset where `fiv run` puts it; where it is not there each verdict is "not run"

    Examples
    --------
    >>> from fiv_cli import api
    >>> hunch = {"source": "a hunch", "text": "it rests", "variable": "attractor"}
    >>> belt = {
    ...     "schema": 1,
    ...     "model": {"name": "belt-1dof"},
    ...     "analysis": [{"kind": "response"}],
    ...     "claim": [{**hunch, "expect": "equilibrium"}],
    ... }
    >>> case = api.load(belt)
    >>> [verdict.verdict for verdict in api.claims(case, api.run(case))]
    ['contradicted']
    """
    from fiv_cli.reading.claims import dataset_of, held_against

    case = _loaded(case)
    if data is not None:
        return held_against(case, _readable(data))
    with _ALONE:
        return held_against(case, *dataset_of(case))


def analyse(
    model: str | Model,
    law: str | Law | None,
    analysis: str,
    start: Mapping[str, float] | Start | None = None,
    settings: Mapping[str, Any] | None = None,
    solver: SolverSettings | None = None,
    options: Mapping[str, Any] | None = None,
    announce: Callable[[str], None] = lambda sentence: None,
    **parameters: float,
) -> Outcome:
    """One analysis of one point, without a case: of a model being written, for example.

    Parameters
    ----------
    model, law : names (``belt-1dof + force_x + v(t)`` of an excited model), also of files that
        `load` has been given; or objects of one's own, written in a file that is imported and each
        under a name of its own; law None: the model's first
    analysis : kind
    start : states that are not zero, or a `Start`
    settings : of the analysis, where they differ from the defaults: as a case writes them, or the
        objects that are made of that (`Section`, `Question`, `Varied`, tuples)
    solver : how motions are integrated
    options : of the model, where they differ from the defaults
    announce : called with a sentence when something must be generated or compiled
    parameters : of the model and the law, SI, where they differ from the defaults

    Returns
    -------
    its `values` are the variables of the dataset, but those of any number of values, such as
    ``section_value``, which its `ragged` holds; its `status` and `reason` say whether there are
    any; its `carry` has the state in which the motion ended, where a "continue" begins

    Raises
    ------
    UsageError
        there is no such model, law, analysis, option, state or parameter.
    CaseError
        a case would not be allowed to have these settings.

    Examples
    --------
    >>> from fiv_cli import api
    >>> found = api.analyse("belt-1dof", "coulomb", "response", start={"x": 0.0}, mu_k=0.2)
    >>> found.values["attractor"], round(found.values["period"], 6)
    ('periodic', 8.068888)
    """
    from fiv_cli.analyses import all_analyses
    from fiv_cli.analyses.base import Request, SolverSettings, as_asked
    from fiv_cli.analyses.execute import answer, prepare

    kind = pick(analysis, all_analyses(), "analysis", "fiv schema")
    solver = solver or SolverSettings()
    setup = _setup(model, law, options or {}, solver.rtol)
    if kind.unsuited(setup.model):
        raise UsageError(f"{kind.unsuited(setup.model)}\nnext: choose another analysis")
    known = _parameters(setup, parameters, {setting.name for setting in kind.settings})
    setup = replace(setup, structural={name: known[name] for name in setup.law.structural})
    if start and not kind.uses_starts:
        raise UsageError(f"{analysis} begins nowhere\nnext: leave start out; {_ASKED}")
    begin = _start(setup, start or {}) if kind.uses_starts else None
    chosen = _settings(kind, setup, parameters, settings or {})
    setup = replace(setup, model=as_asked(setup.model, chosen))
    request = Request(setup, known, analysis, chosen, solver, begin)
    with _computing():
        prepare([request], announce)
        return answer(request)


def _loaded(case: Case) -> Case:
    """The case; UsageError of what is none yet, as its file or its tables."""
    from fiv_cli.case.case import Case as Loaded

    if not isinstance(case, Loaded):
        raise UsageError(
            f"a case is asked for, and a {type(case).__name__} is none\n"
            "next: api.load(...) makes one of a file, or of the tables that it would hold"
        )
    return case


def _setup(
    model: str | Model, law: str | Law | None, options: Mapping[str, Any], rtol: float
) -> Setup:
    """A setup of names that exist."""
    from fiv_cli.codegen.setup import Setup
    from fiv_cli.friction import all_laws, why_unfit
    from fiv_cli.models import all_models, get_model
    from fiv_cli.models.excitation import BETWEEN
    from fiv_cli.own.load import seek

    for name in (model, law):
        if isinstance(name, str):
            seek(name.partition(BETWEEN)[0])
    if isinstance(model, str):
        pick(model.partition(BETWEEN)[0], all_models(), "model", "fiv models")
        model = get_model(model)
    if isinstance(law, str):
        law = pick(law, all_laws(), "friction law", "fiv models --laws")
    texts = {name: _option_text(model, name, value) for name, value in options.items()}
    setup = Setup.of(model, law, texts, rtol=rtol)
    unfit = why_unfit(setup.model, setup.law) if setup.model.contacts else ""
    if unfit:
        raise UsageError(f"{unfit}\nnext: choose another law, see fiv models {setup.model.name}")
    return setup


def _option_text(model: Model, name: str, value: object) -> str:
    """The text that stands for the value of an option."""
    known = {option.name: option for option in model.options}
    option = pick(name, known, f"option of {model.name}", f"fiv models {model.name}")
    try:
        return option.text(value)
    except ValueError as error:
        raise UsageError(f"{name}: {error}\nnext: choose from {option.allowed}") from None


_ASKED = "what an analysis is asked goes into settings = {...}"


def _start(setup: Setup, start: Mapping[str, float] | Start) -> Start:
    """A start from states that exist; the others are zero."""
    from fiv_cli.analyses.base import Start

    if isinstance(start, Start):
        return start
    coordinates = [state.name for state in setup.model.states(setup.options)]
    internal = [state.name for state in setup.law.states]
    known = [*coordinates, *(f"{name}_dot" for name in coordinates), *internal]
    for name in start:
        pick(name, dict.fromkeys(known), f"state of {setup.model.name}", f"name another; {_ASKED}")
    return Start("start", "state", start)


def _parameters(
    setup: Setup, changes: Mapping[str, float], settings: Container[str]
) -> dict[str, float]:
    """Every parameter, where all that are changed exist and none is one of the `settings`."""
    from fiv_cli.codegen.setup import default_parameters

    known = default_parameters(setup.model, setup.law)
    for name, value in changes.items():
        models = f"fiv models {setup.model.name}"
        following = f"settings={{{name!r}: {value!r}}}" if name in settings else models
        pick(name, known, f"parameter of {setup.title}", following)
        if not math.isfinite(value):
            raise UsageError(f"{name} = {value}: no number\nnext: a finite one, in SI")
    return default_parameters(setup.model, setup.law, **changes)


def _settings(
    analysis: Analysis, setup: Setup, changes: Mapping[str, float], given: Mapping[str, Any]
) -> dict[str, Any]:
    """Every setting of an analysis: read as in a case, but for objects (see `analyse`).

    Raises
    ------
    CaseError
        a case would not be allowed to have them.
    """
    from fiv_cli.analyses.base import Question, Section, Varied
    from fiv_cli.analyses.settings import read_settings
    from fiv_cli.case.analysis import Surroundings
    from fiv_cli.case.report import dotted
    from fiv_cli.case.toml import plain

    made = Section | Question | Varied | tuple | None
    objects = {name: value for name, value in given.items() if isinstance(value, made)}
    written = {name: plain(value) for name, value in given.items() if name not in objects}
    asked = {*written, *(setting.name for setting in analysis.settings if setting.required)}
    asked -= objects.keys()
    varied = given.get("parameter", "")
    known = Surroundings(
        setup.model, setup.options, (setup.law,), changes, varied=getattr(varied, "name", varied)
    )
    found = read_settings(analysis.settings, written, known, f"the analysis {analysis.kind!r}")
    problems = [
        Problem(dotted(("settings", *one.place)), one.message, one.allowed, one.suggestion)
        for one in found.refusals
        if one.place[0] in asked
    ]
    if problems:
        raise CaseError("<call>", problems)
    return {**found.value, **objects}


def _analyses_of(data: str | Path | Results) -> dict[str, xr.Dataset]:
    """The datasets of a result, by the name of their analysis."""
    from xarray import Dataset, DataTree

    from fiv_cli.reading.datasets import read_analyses

    if isinstance(data, str | Path):
        with _ALONE:
            return read_analyses(data)
    if isinstance(data, DataTree):
        parts = {name: child.to_dataset() for name, child in data.children.items()}
        return parts or {"": data.to_dataset()}
    if not isinstance(data, Dataset):
        raise UsageError(
            f"{type(data).__name__}: not a dataset\nnext: name the whole result of a run"
        )
    return {"": data}


def _readable(data: str | Path | Results) -> dict[str, xr.Dataset]:
    """The datasets as figures and claims read them."""
    from fiv_cli.reading.select import contiguous

    analyses = _analyses_of(data)
    if isinstance(data, str | Path):
        return analyses
    return {name: contiguous(dataset) for name, dataset in analyses.items()}


@contextmanager
def _place(output: str | Path | None) -> Iterator[Path]:
    """Where to write: at `output`, or in a folder that is gone afterwards."""
    if output is not None:
        yield Path(output)
        return
    with TemporaryDirectory(prefix="fiv-") as folder:
        yield Path(folder) / "run.nc"


@contextmanager
def _computing() -> Iterator[None]:
    """One thread computes at a time, and knows where compiled code goes before it does."""
    from fiv_cli.codegen import cache

    with _ALONE:
        cache.provide()
        yield
