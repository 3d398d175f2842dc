"""Plan: a case as points and chains, enumerated lazily; `fiv check` prints it, `fiv run` runs it.

A chain is a curve of points that may start from their neighbour; a plain grid is chains of
length one. Points are numbered in C order over the dims of the dataset, and nothing is held per
point but numbers in arrays.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice, product, repeat
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import Points, Request, Start, Varied, requirements
from fiv_cli.case.asked import drawn_of_motions, numbers_of_refined
from fiv_cli.case.case import SEVERAL, AnalysisSpec, Axis, Case
from fiv_cli.case.identity import fingerprint
from fiv_cli.case.physics import is_ambiguous
from fiv_cli.data.block import KEY_BYTES
from fiv_cli.data.layout import Dim, Layout
from fiv_cli.data.refined import in_full
from fiv_cli.friction import get_law
from fiv_cli.friction.tabulated import SUFFIX
from fiv_cli.models import get_model
from fiv_cli.models.base import Requirement, leaders
from fiv_cli.notation.amounts import size
from fiv_cli.own.load import know
from fiv_cli.sweep.defaults import defaults, defaults_text, remarks, unequal_defaults
from fiv_cli.sweep.refine import Maps, maps_of
from fiv_cli.sweep.requests import (
    StartEntry,
    Template,
    Values,
    exclusion,
    expand_starts,
    keys_along,
    keys_at,
    packed,
    place_digests,
    point_key,
    request_at,
    resolve_start,
)

Positions = NDArray[np.int64]

AT_ONCE = 2**16  # points whose keys are made together

# Bytes that a run takes without points, and with each in a small sweep, and in a large one, whose
# arrays lie in files, as measured; and of how many points it is said.
ALONE_BYTES, USUAL_BYTES = 330e6, 1100.0
LARGE_BYTES, LARGE_POINT = 600e6, 45.0
MANY = 100_000


@dataclass(frozen=True)
class ChainSet:
    """The chains of one continued start, and of those that begin where they end.

    Attributes
    ----------
    entries : indices of these starts along ``initial``: the legs of each chain, equally long
    positions : (number of chains, length of all legs), in the order in which points are visited
    """

    entries: tuple[int, ...]
    positions: Positions

    @property
    def leg(self) -> int:
        """Length of one leg."""
        return self.positions.shape[1] // len(self.entries)


@dataclass(frozen=True)
class AnalysisPlan:
    """The points of one analysis.

    Attributes
    ----------
    template, layout : what the points share, and how they lie
    maps : the points as maps of which only the borders are run; None: every point is run
    """

    template: Template
    layout: Layout
    maps: Maps | None = None

    @property
    def size(self) -> int:
        """Number of points."""
        return self.layout.size

    def point(self, position: int) -> tuple[Values, int]:
        """Axis values and start index of the point at `position`."""
        (point,) = self.points(np.array([position]))
        return point

    def named(self, position: int) -> str:
        """A point as ``--at`` names it: ``Omega=2.0,initial=far``."""
        values, index = self.point(position)
        names = (name for name, _ in self.template.axes)
        entry = self.entry(index)
        parts = [f"{name}={value}" for name, value in zip(names, values, strict=True)]
        parts += [] if entry is None else [f"initial={entry.label}"]
        return ",".join(parts) or "its only point"

    @cached_property
    def digest(self) -> bytes:
        """Of all points and their order."""
        axes = [
            (axis.name, [packed(self.template, axis.kind, value) for value in axis.values])
            for dim in self.layout.dims
            for axis in dim.axes
        ]
        shape = self.layout.dim_names, self.layout.shape, self.maps is None
        entries = [entry and (entry.label, entry.identity) for entry in self.template.entries]
        return hashlib.sha256(self.template.base + f"{axes}{shape}{entries}".encode()).digest()

    def points(self, positions: Positions) -> Iterator[tuple[Values, int]]:
        """Axis values and start index of points."""
        sizes = [dim.size for dim in self.layout.dims]
        shape = (*sizes, len(self.template.entries))
        *places, starts = (column.tolist() for column in np.unravel_index(positions, shape))
        columns = [
            [axis.values[place] for place in along]
            for dim, along in zip(self.layout.dims, places, strict=True)
            for axis in dim.axes
        ]
        values = zip(*columns, strict=True) if columns else repeat((), len(starts))
        return zip(values, starts, strict=True)

    def entry(self, index: int) -> StartEntry | None:
        """The start with this index along ``initial``; None where there are no starts."""
        return self.template.entries[index]

    def single_positions(self) -> Positions:
        """Positions of all points that start on their own, in order."""
        grid = np.arange(self.size).reshape(-1, len(self.template.entries))
        return grid[:, [not continues(entry) for entry in self.template.entries]].ravel()

    def chain_sets(self) -> tuple[ChainSet, ...]:
        """The chains of every continued start."""
        return tuple(
            ChainSet(tuple(legs), np.hstack([self._chains(i, entry) for i, entry in legs.items()]))
            for legs in self._legs()
        )

    def _legs(self) -> Iterator[dict[int, StartEntry]]:
        """The starts whose chains follow one another, the first of them from a start of its own."""
        chains = {i: e for i, e in enumerate(self.template.entries) if e and continues(e)}
        following = {entry.origin.label: index for index, entry in chains.items() if entry.origin}
        for index in [i for i, entry in chains.items() if not continues(entry.origin)]:
            legs: dict[int, StartEntry] = {}
            last: int | None = index
            while last is not None:
                legs[last] = chains[last]
                last = following.get(chains[last].label)
            yield legs

    def _chains(self, index: int, entry: StartEntry) -> Positions:
        numbers = np.arange(self.size).reshape(self.layout.shape)[..., index]
        dim = dim_of(self.layout.dims, entry.spec.along)
        order = visiting_order(self.layout.dims[dim], entry)
        along_last = np.moveaxis(numbers, dim, -1)[..., order]
        return along_last.reshape(-1, len(order))

    def keys(self, kept: int = KEY_BYTES) -> NDArray[np.uint8]:
        """The first `kept` bytes of the keys of all points, (size, kept)."""
        entries = self.template.entries
        alone = [(index, entry) for index, entry in enumerate(entries) if not continues(entry)]
        keys = np.empty((self.size // len(entries), len(entries), kept), np.uint8)
        places = np.empty((0 if len(alone) == len(entries) else len(keys), KEY_BYTES), np.uint8)
        digests = place_digests(self.template, [_choices_of(dim) for dim in self.layout.dims])
        for begin in range(0, len(keys), AT_ONCE):
            some = list(islice(digests, AT_ONCE))
            rows = slice(begin, begin + len(some))
            for index, entry in alone:
                keys[rows, index] = _rows(b"".join(keys_at(some, entry)))[:, :kept]
            if len(places):
                places[rows] = _rows(b"".join(some))
        for chains in self.chain_sets():
            for points in zip(*np.divmod(chains.positions, len(entries)), strict=True):
                pairs = zip(*points, strict=True)
                along = keys_along((places[i].tobytes(), entries[j]) for i, j in pairs)
                keys[points] = _rows(along)[:, :kept]
        return keys.reshape(-1, kept)

    def chain_key(self, positions: Positions) -> bytes:
        """Key of the last of the first points of a chain."""
        return list(self._chain_keys(positions))[-1]

    def _chain_keys(self, positions: Positions) -> Iterator[bytes]:
        previous = b""
        for position in positions:
            previous = self._key(int(position), previous)
            yield previous

    def _key(self, position: int, previous: bytes) -> bytes:
        values, index = self.point(position)
        return point_key(self.template, values, self.entry(index), previous)

    def excluded(self) -> Counter[str]:
        """What is wrong with parameters -> number of points that will not be computed for it."""
        axes = [axis for dim in self.layout.dims for axis in dim.axes]
        steering = self._steering()
        dims = [dim for dim in self.layout.dims if steering & {a.name for a in dim.axes}]
        others = self.size // max(1, int(np.prod([dim.size for dim in dims], dtype=np.int64)))
        first = {axis.name: axis.values[0] for axis in axes}
        points = ({**first, **choice} for choice in _choices(dims))
        named = (tuple(point[name] for name, _ in self.template.axes) for point in points)
        unmet = (self.unmet(values) for values in named)
        faults = Counter(requirement.fault for requirement in unmet if requirement is not None)
        return Counter({fault: count * others for fault, count in faults.items()})

    def unmet(self, values: Values) -> Requirement | None:
        """Why a point is not computed; None where it is."""
        return exclusion(request_at(self.template, values, None), self.template.linear)

    def _steering(self) -> set[str]:
        """The axes that decide whether a point is computed."""
        model, laws = get_model(self.template.model), map(get_law, self.template.names)
        own = (requirements(model, law, self.template.linear) for law in laws)
        read = {name for some in own for requirement in some for name in requirement.reads}
        return (
            read
            | {leader for name, leader in self.template.followers if name in read}
            | {"friction"}
        )

    def systems(self) -> Iterator[Request]:
        """One request per combination of what may need other generated code."""
        axes = [axis for dim in self.layout.dims for axis in dim.axes]
        structural = self._structural(axes)
        dims = [dim for dim in self.layout.dims if structural & {a.name for a in dim.axes}]
        first = {axis.name: axis.values[0] for axis in axes}
        for choice in _choices(dims):
            by_name = {**first, **choice}
            values = tuple(by_name[name] for name, _ in self.template.axes)
            yield request_at(self.template, values, self._any_start(values))

    def _any_start(self, values: Values) -> Start | None:
        """One start where all are given states; None where one needs more than its numbers."""
        entries = [entry for entry in self.template.entries if entry is not None]
        given = entries and all(entry.spec.kind in ("state", *SEVERAL) for entry in entries)
        return resolve_start(self.template, values, entries[0]) if given else None

    def _structural(self, axes: list[Axis]) -> set[str]:
        names = {axis.name for axis in axes if axis.kind in ("option", "law")}
        for law in self.template.names:
            names |= set(get_law(law).structural)
        return names


@dataclass(frozen=True)
class Plan:
    """What `fiv run` will do."""

    case: Case
    analyses: tuple[AnalysisPlan, ...]

    @property
    def size(self) -> int:
        """Number of points of all analyses."""
        return sum(analysis.size for analysis in self.analyses)

    def __str__(self) -> str:
        return "\n".join(self.describe())

    def defaults(self) -> dict[str, float | str]:
        """What the case leaves to its model and its laws: parameter -> value, SI, or the parameter
        that it follows."""
        return defaults(self.case, self._varied())

    def _varied(self) -> set[str]:
        """What analyses vary themselves."""
        return {name for one in self.analyses for name in _without_own_value(one.template)}

    def describe(self, is_estimated: bool = False) -> list[str]:
        """The plan in lines for people; what it costs is not guessed where it `is_estimated`."""
        case = self.case
        head = [
            f"{case.source}: {case.title}" if case.title else case.source,
            f"  model {case.model}, friction {_laws(case)}",
            *(f"  {law}: {get_law(law).title}" for law in case.laws if law.endswith(SUFFIX)),
            *(f"  {_curve_text(name, points)}" for name, points in case.schedule.curves),
        ]
        head += [
            *defaults_text(case, self._varied()),
            *(f"  {said}" for said in (*unequal_defaults(case), *remarks(case))),
        ]
        lines = [line for analysis in self.analyses for line in _described(analysis)]
        lines += [
            f"  figure {name}: of a motion, which no analysis here keeps: fiv history computes one "
            "(--at PLACE -o FILE.nc), fiv plot FILE.nc draws it"
            for name in drawn_of_motions(case)
        ]
        lines += [
            f"  figure {name}: {variable} is known only where points are run: [sweep] refine "
            f"fills in the class of the others; {_in_full(case)} -o ANOTHER.nc runs all"
            for name, variable in numbers_of_refined(case)
        ]
        guessed = self.size >= MANY and not is_estimated
        return [*head, *lines, *([_cost_of(self.size)] if guessed else [])]


def make_plan(case: Case) -> Plan:
    """The plan of a valid case."""
    know(case.own.values())
    analyses = tuple(_analysis_plan(case, spec) for spec in case.analyses)
    return Plan(case, analyses)


def _analysis_plan(case: Case, spec: AnalysisSpec) -> AnalysisPlan:
    analysis = get_analysis(spec.kind)
    dims = _dims(case, analysis.uses_starts)
    entries = expand_starts(case.starts) if analysis.uses_starts else None
    template = _template(case, spec, dims, entries)
    layout = Layout(
        name=spec.name,
        kind=spec.kind,
        model=case.model,
        options=case.options,
        settings=spec.settings,
        dims=dims,
        labels=None if entries is None else tuple(entry.label for entry in entries),
        laws=case.laws,
        varying=case.varying,
        fixed=_fixed(template),
        internal=case.internal,
        reach=case.reach,
    )
    maps = None if case.refinement is None else maps_of(layout, case.refinement)
    return AnalysisPlan(template, layout, maps)


def _without_own_value(template: Template) -> set[str]:
    """Parameters that the analysis varies, and for which the case's own value says nothing."""
    asked = get_analysis(template.analysis).settings
    if not any(one.name == "parameter" and one.required for one in asked):
        return set()
    varied: Varied = template.settings["parameter"]
    return {varied.name, *varied.followers}


def _fixed(template: Template) -> dict[str, float]:
    """The parameters that have one value at all points, under every law that has them."""
    varied = {*template.schedule.names, *_without_own_value(template)}
    laws = [get_law(law) for law in template.parameters]
    pairs = [pair for fixed in template.parameters.values() for pair in fixed.items()]
    counts = Counter(name for name, _ in {*pairs})
    varied |= {n for n, count in counts.items() if count > 1 or is_ambiguous(laws, n)}
    return {name: value for name, value in pairs if name not in varied}


def _template(
    case: Case,
    spec: AnalysisSpec,
    dims: tuple[Dim, ...],
    entries: tuple[StartEntry, ...] | None,
) -> Template:
    axes = [axis for dim in dims for axis in dim.axes]
    model = get_model(case.model)
    own = {law: model.parameters_under(get_law(law)) for law in case.laws}
    every = [parameter for table in own.values() for parameter in table]
    fixed = {law: _unvaried(case, law) for law in case.laws}
    return Template(
        model=case.model,
        law=case.law,
        options=case.options,
        parameters=fixed,
        names={law: tuple(p.name for p in table) for law, table in own.items()},
        followers=tuple(leaders(every, [axis.name for axis in axes]).items()),
        axes=tuple((axis.name, axis.kind) for axis in axes),
        entries=entries or (None,),
        analysis=spec.kind,
        settings=spec.settings,
        solver=case.solver,
        linear=get_analysis(spec.kind).linear,
        base=bytes.fromhex(fingerprint(case, [spec], starts=())),
        schedule=case.schedule,
        own=tuple(dict.fromkeys(case.own.values())),
    )


def _unvaried(case: Case, law: str) -> dict[str, float]:
    """The parameters under `law` that no axis decides, SI."""
    varied = {axis.name for axis in case.axes}
    return {n: v for n, v in case.parameters_at(law, {}).items() if n not in varied}


def _dims(case: Case, uses_starts: bool) -> tuple[Dim, ...]:
    """The grid's dims in the order of the file; components of the start only where there is one."""
    dims: list[tuple[Axis, ...]] = []
    for axis in case.axes:
        group = next((zipped for zipped in case.zips if axis.name in zipped), (axis.name,))
        members = tuple(a for a in case.axes if a.name in group)
        if members not in dims:
            dims.append(members)
    wanted = [tuple(a for a in axes if uses_starts or a.kind != "start") for axes in dims]
    return tuple(Dim(axes) for axes in wanted if axes)


def dim_of(dims: tuple[Dim, ...], name: str) -> int:
    return next(i for i, dim in enumerate(dims) if name in [axis.name for axis in dim.axes])


def visiting_order(dim: Dim, entry: StartEntry) -> list[int]:
    """Indices along `dim` by rising or falling value of the axis that is followed."""
    axis = next(axis for axis in dim.axes if axis.name == entry.spec.along)
    indices = range(dim.size)
    order = sorted(indices, key=axis.values.__getitem__) if axis.kind == "parameter" else indices
    return list(order) if entry.spec.direction == "up" else list(order)[::-1]


def _choices(dims: list[Dim]) -> Iterator[dict[str, Any]]:
    """Every combination of the values of `dims`, by axis name."""
    for indices in product(*(range(dim.size) for dim in dims)):
        yield {
            axis.name: axis.values[index]
            for dim, index in zip(dims, indices, strict=True)
            for axis in dim.axes
        }


def _rows(keys: bytes) -> NDArray[np.uint8]:
    """Keys that stand one after the other, each as a row."""
    return np.frombuffer(keys, np.uint8).reshape(-1, KEY_BYTES)


def _choices_of(dim: Dim) -> list[Values]:
    """The values along a dim: of each axis one."""
    return list(zip(*(axis.values for axis in dim.axes), strict=True))


def continues(entry: StartEntry | None) -> bool:
    """Whether the points of a start are chains."""
    return entry is not None and entry.spec.kind == "continue"


def _laws(case: Case) -> str:
    names = [axis.values for axis in case.axes if axis.kind == "law"]
    return ", ".join(names[0]) if names else case.law


def _in_full(case: Case) -> str:
    """What runs every point of a refined map."""
    halved = () if case.refinement is None else case.refinement.axes
    return in_full({axis.name: axis.values for axis in case.axes if axis.name in halved})


def _described(analysis: AnalysisPlan) -> list[str]:
    layout = analysis.layout
    sizes = zip(layout.dim_names, layout.shape, strict=True)
    grid = " x ".join(f"{name} {size}" for name, size in sizes) or "a single point"
    title = layout.kind if layout.name == layout.kind else f"{layout.name} ({layout.kind})"
    lines = [f"  {title}: {counted(layout.size)} ({grid})"]
    for dim in layout.dims:
        lines.extend(f"    {_axis_text(axis)}" for axis in dim.axes)
    lines.extend(_varied(layout))
    if analysis.maps is not None:
        lines.append(f"    {_refined_text(analysis.maps, layout)}")
    for chains in analysis.chain_sets():
        lines.extend(_chains_text(analysis, chains, index) for index in chains.entries)
    for fault, count in analysis.excluded().items():
        lines.append(f"    {counted(count)} where {fault} will not be computed")
    return lines


STEPS = {
    "shorter": "in shorter steps where one of the grid loses the class",
    "grid": "each from where the one before ended (a branch may be left before it ends)",
}


def _chains_text(analysis: AnalysisPlan, chains: ChainSet, index: int) -> str:
    """``up: 2 chains of 8 points along N up, ...``."""
    entry = analysis.template.entries[index]
    assert entry is not None
    spec, number = entry.spec, counted(len(chains.positions), "chain")
    begun = "" if index == chains.entries[0] else f", from the end of {spec.from_label}"
    points = f"{number} of {counted(chains.leg)}"
    way = f"{points} along {spec.along} {spec.direction}{begun}"
    return f"    {entry.label}: {way}, {STEPS[spec.steps]}"


def _varied(layout: Layout) -> list[str]:
    """The bracket of a parameter that the analysis itself varies, and its beginning, if any."""
    settings = layout.settings
    varied, bracket = settings.get("parameter"), settings.get("bracket")
    if varied is None or bracket is None:
        return []
    unit = "" if varied.unit == "1" else f" {varied.unit}"
    followers = f", and with it {', '.join(varied.followers)}" if varied.followers else ""
    text = f"    {varied.name} is varied from {bracket[0]!r} to {bracket[1]!r}{unit}{followers}"
    if varied.name in layout.fixed:
        return [f"{text}, both ways from the case's own {layout.fixed[varied.name]!r}"]
    if "scan" not in settings:
        return [text]
    width = f"{settings['width'] * (bracket[1] - bracket[0]):g}{unit}"
    return [f"{text}: {settings['scan']} values, each change bisected to {width}"]


def _refined_text(maps: Maps, layout: Layout) -> str:
    """What is run of a refined analysis, as far as a plan can tell."""
    coarse = " x ".join(f"{dim} {size}" for dim, size in maps.coarse.items())
    least = len(maps.numbers) * prod(maps.coarse.values())
    halved = counted(maps.refinement.levels, "time")
    return (
        f"{coarse} halved {halved} along the borders of {maps.refinement.of}: "
        f"{least} to {layout.size} points are run, the class of the others is filled in"
    )


def _cost_of(points: int) -> str:
    """What so many points hold, and what to type for how long they take."""
    memory = min(ALONE_BYTES + points * USUAL_BYTES, LARGE_BYTES + points * LARGE_POINT)
    return (
        f"  {points:,} points: some {size(memory)} of memory; how long depends on "
        "what moves: type fiv check --estimate, which runs a few"
    )


def counted(count: int, noun: str = "point") -> str:
    """``1 point``, ``2 points``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _curve_text(name: str, points: Points) -> str:
    """``Omega = 6.283 at 0 s, 0.0 at 35.0 s``; the middle of a long curve is left out."""
    texts = [f"{value!r} at {time!r} s" for time, value in points]
    if len(texts) > 6:
        texts = [*texts[:2], f"... ({len(texts)} points)", *texts[-2:]]
    return f"{name} varies in time: {', '.join(texts)}"


def _axis_text(axis: Axis) -> str:
    values = axis.values
    if axis.kind in ("parameter", "start") and len(values) > 4:
        ends = (values[0], values[-1]) if _is_sorted(values) else (min(values), max(values))
        between = "..." if _is_sorted(values) else "to"
        return f"{axis.name} = {ends[0]!r} {between} {ends[1]!r} ({len(values)} values)"
    return f"{axis.name} = " + ", ".join(map(_value_text, values))


def _is_sorted(values: tuple[float, ...]) -> bool:
    return list(values) in (sorted(values), sorted(values, reverse=True))


def _value_text(value: Any) -> str:
    text = str(value)
    return f'"{text}"' if "," in text else text
