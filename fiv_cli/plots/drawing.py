"""Which figures a dataset has, and drawing one of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.case.case import FigureSpec
from fiv_cli.errors import CrampedFigureError, UsageError
from fiv_cli.flags import MOTION_OF_A_CYCLE, NOT_COMPUTED
from fiv_cli.notation.names import listed, pick
from fiv_cli.plots import (
    basin,
    bifurcation,
    branch,
    curve,
    eigenvalues,
    fitting,
    history,
    mode_shape,
    motion,
    phase,
    points,
    spectrogram,
    spectrum,
    style,
)
from fiv_cli.plots import map as map_
from fiv_cli.plots.captions import caption
from fiv_cli.plots.labels import has_symbol, name_of, quantity, title_of, value_label
from fiv_cli.plots.points import Layer, Settings
from fiv_cli.reading import select, shares, take
from fiv_cli.reading.datasets import analysis_of, figures_in, is_class, read_analyses
from fiv_cli.reading.lent import changed, lent

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    Source = xr.Dataset | str | Path | dict[str, xr.Dataset]
    Sources = Source | Sequence[tuple[str, Source]]
    _File = tuple[str, dict[str, xr.Dataset]]  # its label, its analyses by name


OF_LINES, MOST_NAMED = ("curve", "bifurcation"), 6  # starts of one table that are told apart


@dataclass(frozen=True)
class Kind:
    """A kind of figure.

    Attributes
    ----------
    suits : whether a dataset can be drawn so
    draw : ``(layers, settings) -> Figure``
    overlays : whether several datasets share one figure
    completed : whether it takes more from datasets that have nothing of what it shows itself
    unasked : whether one that suits is drawn so where its case asks for no figures
    """

    suits: Callable[[xr.Dataset], bool]
    draw: Callable[[Sequence[Layer], Settings], Figure]
    overlays: bool = False
    completed: bool = False
    unasked: Callable[[xr.Dataset], bool] = lambda dataset: True


# In the order in which a dataset without [[figure]] tables is asked what suits it.
KINDS: dict[str, Kind] = {
    "map": Kind(map_.suits, map_.draw, unasked=map_.fills_plane),
    "basin": Kind(basin.suits, basin.draw, completed=True),
    "bifurcation": Kind(bifurcation.suits, bifurcation.draw, overlays=True, completed=True),
    "curve": Kind(curve.suits, curve.draw, overlays=True, unasked=curve.has_an_axis),
    "eigenvalues": Kind(eigenvalues.suits, eigenvalues.draw, completed=True),
    "history": Kind(history.suits, history.draw, overlays=True),
    "phase": Kind(phase.suits, phase.draw, overlays=True),
    "spectrum": Kind(spectrum.suits, spectrum.draw),
    "spectrogram": Kind(spectrogram.suits, spectrogram.draw),
    "mode-shape": Kind(mode_shape.suits, mode_shape.draw),
    "branch": Kind(branch.suits, branch.draw, overlays=True),
}

# A default figure is left out where a figure before it says the same and more.
SAID_BY = {
    "basin": {"map"},
    "bifurcation": {"map", "basin"},
    "curve": {"map", "basin", "eigenvalues"},
    "eigenvalues": {"map"},
    "spectrum": {"history"},
    "spectrogram": {"history"},
}


def figures_of(source: Source) -> list[FigureSpec]:
    """The figures that the case of the dataset asks for, else the default ones."""
    analyses = _analyses(source)
    return figures_in(analyses) or default_figures(analyses)


def default_figures(source: Source) -> list[FigureSpec]:
    """One figure of each kind that says something about each analysis of the dataset.

    Names are unique: a second ``map`` is ``map-2``.
    """
    figures: list[FigureSpec] = []
    for name, dataset in _analyses(source).items():
        for kind in _default_kinds(dataset):
            count = 1 + sum(figure.kind == kind for figure in figures)
            unique = kind if count == 1 else f"{kind}-{count}"
            figures.append(FigureSpec(unique, kind, {"analysis": name} if name else {}))
    return figures


def _default_kinds(dataset: xr.Dataset) -> list[str]:
    fitting = (kind for kind, entry in KINDS.items() if entry.suits(dataset))
    suiting = [kind for kind in fitting if KINDS[kind].unasked(dataset)]
    return [kind for kind in suiting if not SAID_BY.get(kind, set()) & set(suiting)]


def kinds_that_suit(source: Source) -> list[str]:
    """The kinds of figures that some analysis of the dataset can be drawn as."""
    analyses = _analyses(source).values()
    return [name for name, kind in KINDS.items() if any(map(kind.suits, analyses))]


def can_draw(source: Source, figure: FigureSpec) -> bool:
    """Whether the dataset holds what a figure of this kind shows.

    The history of one point of a sweep carries the figures of the sweep, for example.
    """
    analyses = _analyses(source)
    named = str(figure.settings.get("analysis", ""))
    candidates = [analyses[named]] if named in analyses else list(analyses.values())
    suiting = [dataset for dataset in candidates if _kind(figure.kind).suits(dataset)]
    return any(_is_selected(dataset, figure) for dataset in suiting)


def _is_selected(dataset: xr.Dataset, figure: FigureSpec) -> bool:
    """Whether a motion in time is one of those that a figure selects; of a sweep some always is."""
    if not motion.suits(dataset):
        return True
    axes = {name: select.axis_of(dataset, name) for name in select.axis_names(dataset)}
    of_grid = {n: axis for n, axis in axes.items() if axis.dims[0] in points.grid_dims(dataset)}
    wanted = {n.replace(".", "_"): one for n, one in figure.settings.get("select", {}).items()}
    return all(_has_some(axis, wanted[name]) for name, axis in of_grid.items() if name in wanted)


def _has_some(axis: xr.DataArray, wanted: Any) -> bool:
    """Whether an axis has some of what is wanted."""
    if isinstance(wanted, list):
        return any(_has_some(axis, one) for one in wanted)
    try:
        return bool(select.matching(axis, wanted, nearest=False).any())
    except select.SelectionError:
        return False


def possible_figures(source: Source) -> list[FigureSpec]:
    """The figures of the case that the dataset can show; where it shows none, the default ones."""
    figures = [figure for figure in figures_of(source) if can_draw(source, figure)]
    return figures or default_figures(source)


def nothing_suits(source: Source) -> UsageError:
    """That no kind of figure suits a dataset; of a single point, the axes that it may be given."""
    datasets = _analyses(source).values()
    single = all(one["status"].size == one.sizes.get("initial", 1) for one in datasets)
    fixed = {str(name) for one in datasets for name, axis in one.coords.items() if not axis.ndim}
    has_cycle = any("cycle_section" in one for one in datasets)
    of_a_cycle = f"; or draw the motion {MOTION_OF_A_CYCLE}" * has_cycle
    if single and fixed:
        return UsageError(
            "a single point, which no kind of figure suits\n"
            f"next: give the case an axis to draw it along, under [grid]: {listed(sorted(fixed))}"
            f"{of_a_cycle}"
        )
    return UsageError("no kind of figure suits this dataset\nnext: `fiv show` says what it holds")


def figures_called(source: Source, name: str) -> list[FigureSpec]:
    """The figures called `name`, or of that kind; one that the case does not ask for as it comes.

    Raises
    ------
    UsageError : neither a figure nor a kind is called so
    """
    figures = figures_of(source)
    named = [figure for figure in figures if figure.name == name]
    named = named or [figure for figure in figures if figure.kind == name]
    names = [figure.name for figure in figures]
    command = next((str(one.attrs.get("history", "")) for one in _analyses(source).values()), "")
    again = f"`{command}` again" if command.startswith("fiv history") else "run it again first"
    following = f"fiv kinds figure; of one that the case has got since it ran, {again}"
    pick(name, dict.fromkeys([*names, *KINDS]), "figure, nor kind of figure,", following)
    return named or [FigureSpec(name, name, {})]


MOST_PROPOSED = 300.0  # mm: no wider figure is proposed


def draw(
    source: Sources,
    figure: FigureSpec,
    axis: Axes | None = None,
    look: style.Look | None = None,
) -> Figure:
    """Draw one figure.

    Parameters
    ----------
    source : a dataset, its path, its analyses by name, or several of them as (label, source)
        for a figure that overlays them
    figure : what to draw
    axis : the panel to draw on, of a figure of one panel; None: the figure makes its own
    look : what it is for; None: a screen

    Raises
    ------
    UsageError : the dataset does not hold what the figure shows, and says what it holds; or the
        figure is too small for it, and how large it may be
    """
    try:
        return _drawn(source, figure, axis, look)
    except CrampedFigureError as error:
        wider = _wide_enough(source, figure, look or style.Look(), error.width)
        raise UsageError(f"{error}\nnext: {wider}") from None


def _wide_enough(source: Sources, figure: FigureSpec, look: style.Look, width: float) -> str:
    """What gives the panels of a figure room, as drawing it anew has shown."""
    fewer = "choose fewer panels with `select` in the figure"
    for wide in np.arange(10.0 * (width // 10.0 + 1.0), MOST_PROPOSED, 10.0).tolist():
        with suppress(CrampedFigureError):
            _drawn(source, figure, None, replace(look, width=wide))
            return f"--width {wide:g}; or {fewer}"
    return "leave --height out" if look.height else fewer


def _drawn(
    source: Sources, figure: FigureSpec, axis: Axes | None, look: style.Look | None
) -> Figure:
    kind = _kind(figure.kind)
    files = _files(source, kind)
    if not (kind.completed and any(_has_asked(held, figure) for _, held in files)):
        for _, held in files:
            _refuse_other_analysis(held, figure)
    layers = _layers(files, figure, kind)
    settings = _checked(figure)
    if "take" in settings:
        settings = {**settings, "variable": settings["take"]["what"]}
    words = _words(layers, settings)
    with style.looks(axis, look, words, _called(words, layers), _names_of_starts(layers)):
        drawn = kind.draw(layers, settings)
        points.relabel(drawn, settings)
        for ax in style.own_axes(drawn) if settings.keys() & {"xlim", "ylim"} else ():
            points.show_on_the_frame(ax)
        fitting.finish(drawn)
        without = [one.dataset.attrs.get("without", "") for one in layers]
        told = {"", *without[:1]} if style.has_titles() else {""}  # a title tells that of the first
        untold = dict.fromkeys(word for word in without if word not in told)
        untitled = [
            *_untitled(files, figure, drawn),
            *caption(drawn, [one.dataset for one in layers]),
        ]
        style.add_notes(drawn, [*changed(_lined(figure)), *untold, *untitled])
        return drawn


def _untitled(files: Sequence[_File], figure: FigureSpec, drawn: Figure) -> list[str]:
    """That files have no title in common, where one would stand above."""
    titles = {title_of(next(iter(held.values())).attrs) for _, held in files}
    has_one = any(str(drawn.get_label()).startswith(title) for title in titles if title)
    if len(titles) < 2 or has_one or "title" in figure.settings or not style.has_titles():
        return []
    return ["no title, for those of the files differ; title = TEXT in the figure of the first"]


def _files(source: Sources, kind: Kind) -> list[_File]:
    """The files of a figure, what the kind of figure lays over the others last."""
    named: Sequence[tuple[str, Any]] = (
        source if isinstance(source, list | tuple) else [("", source)]
    )
    files = [(label, _analyses(one)) for label, one in named]
    return sorted(files, key=lambda one: not any(map(kind.suits, one[1].values())))


def _layers(files: Sequence[_File], figure: FigureSpec, kind: Kind) -> list[Layer]:
    """What is drawn of each file, under the titles and names that they have beside one another."""
    labels = {label for _, held in files for label in _starts(held)}
    chosen = [_with_own_select(figure, held, [other for _, other in files]) for _, held in files]
    layers = [
        _layer(name, held, _shared(own, held, labels), kind)
        for own, (name, held) in zip(chosen, files, strict=True)
    ]
    alone = [one for one in layers if kind.suits(one.dataset) or not kind.completed]
    if len(alone) > 1 and not kind.overlays:
        raise UsageError(f"a figure of kind {figure.kind} shows one dataset\ndraw them one by one")
    if "take" in figure.settings:
        layers = [
            _with_taken(one, held, figure) for one, (_, held) in zip(layers, files, strict=True)
        ]
    asked = [
        one
        for one, (_, held) in zip(layers, files, strict=True)
        if _has_asked(held, figure) and (kind.overlays or kind.suits(one.dataset))
    ]
    if "title" in figure.settings or len({title_of(one.dataset.attrs) for one in asked}) > 1:
        layers = [replace(one, dataset=_retitled(one.dataset, figure)) for one in layers]
    along_starts = "initial" in (figure.settings.get("x"), figure.settings.get("y"))
    if (figure.kind in OF_LINES or along_starts) and "take" not in figure.settings:
        layers = [replace(one, dataset=_few_named(one.dataset)) for one in layers]
    if len(layers) > 1:  # each of them is called by what it differs in
        layers = [replace(one, dataset=_untold(one.dataset)) for one in layers]
    return layers


def _untold(dataset: xr.Dataset) -> xr.Dataset:
    """Whose title does not tell what was set on the command line."""
    return dataset.assign_attrs(overrides="", overridden=dataset.attrs.get("overrides", ""))


def _few_named(dataset: xr.Dataset) -> xr.Dataset:
    """With a few starts of one table told apart: ``mine 003``; many are lines that look alike."""
    if "initial" not in dataset.dims:
        return dataset
    names = [str(name) for name in dataset["initial"].values]
    count = Counter(map(points.stem, names))
    few = {one for one in shares.labels_of(dataset, "table") if 1 < count[one] <= MOST_NAMED}
    called = [
        f"{points.stem(name)} {name.rpartition('-')[2]}" if points.stem(name) in few else name
        for name in names
    ]
    return dataset.assign_coords(initial=("initial", called, dataset["initial"].attrs))


def _with_taken(layer: Layer, held: dict[str, xr.Dataset], figure: FigureSpec) -> Layer:
    """The layer of what the figure takes of a variable, over what it takes it of."""
    dataset = _taken(layer.dataset, _checked(_with_own_take(figure, held)))
    return replace(layer, dataset=dataset, beside=(layer.dataset, *layer.beside))


def _words(layers: Sequence[Layer], settings: Settings) -> dict[str, str]:
    """What a figure calls things; no part of a name that the user gave is a word of the tool's."""
    given = [one.dataset.attrs.get("called", "") for one in layers]
    given += [str(settings.get(f"{which}label", "")) for which in "xyz"]
    return {**{name: name for name in given if name}, **settings.get("words", {})}


def _called(words: Collection[str], layers: Sequence[points.Layer]) -> dict[str, tuple[str, ...]]:
    """What a figure calls those of some words that are names of variables: at axes, and levels; not
    where other cases have several that are called alike, each of which stands for itself."""
    every = [dataset for one in layers for dataset in (one.dataset, *one.beside)]
    known = {str(name): one[name] for one in every for name in one.data_vars}
    meant = {word: _meant(word, known) for word in words}
    of_cases = Counter(name_of(one) for name, one in known.items() if ":" in name)
    return {
        word: (name_of(known[name]), *_in_words(known[name], name.rpartition(":")[2]))
        for word, name in meant.items()
        if name in known and (":" not in name or of_cases[name_of(known[name])] < 2)
    }


def _meant(word: str, known: Collection[str]) -> str:
    """The variable that a word names: one of another case needs no case, if it is the only one."""
    others = [name for name in known if name.endswith(f":{word}")]
    return others[0] if len(others) == 1 and word not in known else word


def _in_words(variable: xr.DataArray, name: str) -> list[str]:
    """What levels of a variable are called; nothing where several may have its symbol."""
    return [] if has_symbol(variable, name) else [quantity(variable, name)]


def _names_of_starts(layers: Sequence[points.Layer]) -> set[str]:
    """What starts are called, the members of a random one together."""
    every = [dataset for one in layers for dataset in (one.dataset, *one.beside)]
    named = (one["initial"].values.ravel() for one in every if "initial" in one.coords)
    return {points.stem(str(name)) for names in named for name in names}


def _checked(figure: FigureSpec) -> Settings:
    checked: Any = figure.settings  # by `FigureTable`, where the case or the dataset was read
    settings: Settings = checked
    return settings


def _own(figure: FigureSpec, analyses: dict[str, xr.Dataset]) -> FigureSpec | None:
    """The figure of that name, and kind, that the case of a file has."""
    whose = figure.name, figure.kind
    return next((one for one in figures_in(analyses) if (one.name, one.kind) == whose), None)


def _with_own_select(
    figure: FigureSpec, analyses: dict[str, xr.Dataset], every: Sequence[dict[str, xr.Dataset]]
) -> FigureSpec:
    """The figure of one of the files with what another selects for its own of that name."""
    own, known = _own(figure, analyses), filter(None, (_own(figure, one) for one in every))
    selection = figure.settings.get("select", {})
    if own is None or selection not in [one.settings.get("select", {}) for one in known]:
        return figure
    selected = own.settings.get("select", {})
    return replace(figure, settings={**figure.settings, "select": selected})


def _with_own_take(figure: FigureSpec, analyses: dict[str, xr.Dataset]) -> FigureSpec:
    """The figure with what a file's own of that name takes: the same, but of axes of its own."""
    own = (_own(figure, analyses) or figure).settings
    if own.get("take", {}).get("what") != figure.settings["take"]["what"]:
        return figure
    kept = {key: own[key] for key in ("take", "variable") if key in own}
    return replace(figure, settings={**figure.settings, **kept})


def _taken(dataset: xr.Dataset, settings: Settings) -> xr.Dataset:
    """The dataset as what the figure takes of its variable."""
    name = points.one_variable(settings, "attractor")
    how = take.in_order(settings["take"], settings.get("select", {}))
    found = take.taken_of_each(dataset, name, how)
    found = take.told_by_class(found, dataset, name, how)
    found = found.assign_attrs(without=take.without_value(dataset, name, how))
    return shares.with_standard_error(found, dataset, how, [*shares.drawn_of(dataset)])


def _retitled(dataset: xr.Dataset, figure: FigureSpec) -> xr.Dataset:
    """Under the figure's own title; several datasets of different titles have none in common."""
    return dataset.assign_attrs(title=figure.settings.get("title", ""), reference="")


def _kind(name: str) -> Kind:
    if name not in KINDS:
        raise UsageError(f"{name}: no kind of figure\nthere are: {', '.join(KINDS)}")
    return KINDS[name]


def _has_asked(analyses: dict[str, xr.Dataset], figure: FigureSpec) -> bool:
    """Whether there is the analysis that a figure names, if any; a single one has no name."""
    wanted = figure.settings.get("analysis")
    return wanted is None or wanted in analyses or list(analyses) == [""]


def _refuse_other_analysis(analyses: dict[str, xr.Dataset], figure: FigureSpec) -> None:
    if not _has_asked(analyses, figure):
        wanted = figure.settings["analysis"]
        raise UsageError(f"{wanted}: no analysis of this dataset\nit has: {', '.join(analyses)}")


def _layer(label: str, analyses: dict[str, xr.Dataset], figure: FigureSpec, kind: Kind) -> Layer:
    """The analysis that the figure is about, narrowed to what it selects."""
    wanted = figure.settings.get("analysis")
    named = [analyses[wanted]] if wanted in analyses else _own_first(analyses, figure.kind)
    first = _listed(figure.settings.get("variable", []))[:1]
    having = (d for d in named if all(name in d for name in first) and kind.suits(d))
    # a dataset that no figure of the kind suits is drawn anyway: the kind says what it lacks
    dataset = max(having, key=lambda d: _holds(d, figure), default=named[0])
    is_drawn = kind.suits(dataset)
    selection = figure.settings.get("select", {}) if is_drawn else _selection_of(dataset, figure)
    others = [*(d for d in analyses.values() if d is not dataset), *lent(_lined(figure))]
    beside = tuple(_selected(d, _selection_of(d, figure)) for d in others)
    # critical values lie over what is drawn of other files, and know of no starts
    is_laid = "critical_value" in dataset and first and first[0] not in dataset
    narrowed = select.subset if is_drawn and not is_laid else _selected
    of_lines = _axes_of_lines(figure, dataset, beside) - {*select.axis_names(dataset)}
    results = {name: selection[name] for name in selection if name in dataset.data_vars}
    own = {axis: selection[axis] for axis in selection if axis not in {*of_lines, *results}}
    part = _of_classes(narrowed(dataset, own), results)
    return Layer(label, _telling(part, dataset, figure), beside)


def _of_classes(part: xr.Dataset, results: Mapping[str, Any]) -> xr.Dataset:
    """The part with the numbers alone that stand where results have the classes that are wanted.

    Points of other classes, undecided ones among them, are no gaps of it; those without one are.
    """
    for name, wanted in results.items():
        mask = select.having(part[name], wanted)
        if {*mask.dims} <= {*part["status"].dims}:
            others = ~mask & ~is_class(part[name], (NOT_COMPUTED,))
            part = part.assign({points.NOT_SELECTED: part.get(points.NOT_SELECTED, False) | others})
        held = [v for v in part.data_vars if {*mask.dims} <= {*part[v].dims}]
        numbers = [v for v in held if part[v].dtype.kind == "f"]
        part = part.assign({v: part[v].where(mask).assign_attrs(part[v].attrs) for v in numbers})
    return part


def _telling(part: xr.Dataset, whole: xr.Dataset, figure: FigureSpec) -> xr.Dataset:
    """The part that a figure selects, for its title with which of several contacts, modes, ... .

    These are axes that not the grid has, but what is drawn.
    """
    names = [name for key in ("variable", "y") for name in _listed(figure.settings.get(key, []))]
    own = {str(dim) for name in names if name in part for dim in part[name].dims}
    left = [dim for dim in sorted(own) if part.sizes[dim] == 1 < whole.sizes[dim]]
    axes = [select.axis_of(part, dim) for dim in left if dim not in points.grid_dims(part)]
    words = [value_label(axis, axis.values[0]) for axis in axes]
    return part.assign_attrs(of_several=points.joined(*words))


def _listed(names: str | list[str]) -> list[str]:
    return [names] if isinstance(names, str) else names


def _axes_of_lines(
    figure: FigureSpec, dataset: xr.Dataset, beside: Sequence[xr.Dataset]
) -> set[str]:
    """The axes of other analyses of whose variables lines are drawn, such as their mode."""
    lacking = {*_listed(figure.settings.get("variable", []))} - {*dataset.data_vars}
    drawn = lacking.union(_lined(figure))
    holding = [one for one in beside if not drawn.isdisjoint(map(str, one.data_vars))]
    return {axis for one in holding for axis in select.axis_names(one)}


def _lined(figure: FigureSpec) -> Sequence[str]:
    """The variables that a map names of which it draws lines."""
    level = figure.settings.get("level")
    return [*level] if isinstance(level, Mapping) else []


def _own_first(analyses: dict[str, xr.Dataset], kind: str) -> list[xr.Dataset]:
    """The analyses, those before that compute what the figure is called after."""
    kinds = {name: analysis_of(one, name).get("kind") for name, one in analyses.items()}
    return [analyses[name] for name in sorted(analyses, key=lambda name: kinds[name] != kind)]


def _shared(figure: FigureSpec, analyses: dict[str, xr.Dataset], labels: set[str]) -> FigureSpec:
    """The figure without those of several starts that it selects which others alone have."""
    selection = figure.settings.get("select", {})
    wanted, own = selection.get("initial"), _starts(analyses)
    if not isinstance(wanted, list):
        return figure
    kept = [one for one in wanted if one in own or one not in labels] or wanted
    return replace(figure, settings={**figure.settings, "select": {**selection, "initial": kept}})


def _starts(analyses: dict[str, xr.Dataset]) -> set[str]:
    """The labels of the starts of a file."""
    having = (one["initial"].values for one in analyses.values() if "initial" in one.coords)
    return {str(label) for labels in having for label in np.ravel(labels)}


def _selected(dataset: xr.Dataset, selection: Mapping[str, Any]) -> xr.Dataset:
    """An analysis beside the one that is drawn, narrowed as far as it has these axes.

    From which start a branch was found matters to none of its cycles.
    """
    known = {*select.axis_names(dataset)} - ({"initial"} if branch.suits(dataset) else set())
    own = {name: wanted for name, wanted in selection.items() if name.replace(".", "_") in known}
    try:
        return select.subset(dataset, own)
    except select.SelectionError:  # it has other starts
        return dataset


def _selection_of(dataset: xr.Dataset, figure: FigureSpec) -> Mapping[str, Any]:
    """What a figure selects of another analysis: of the cycles that lie over a diagram all starts.

    From which a cycle was found tells nothing of it.
    """
    selection: Mapping[str, Any] = figure.settings.get("select", {})
    over = figure.kind == "bifurcation" and "cycle_period" in dataset
    return {name: selection[name] for name in selection if name != "initial" or not over}


def _holds(dataset: xr.Dataset, figure: FigureSpec) -> bool:
    return all(name in dataset for name in _listed(figure.settings.get("variable", [])))


def _analyses(source: Source) -> dict[str, xr.Dataset]:
    if isinstance(source, str | Path):
        return read_analyses(source)
    return dict(source) if isinstance(source, dict) else {"": source}
