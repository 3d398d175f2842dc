"""What a publication says, held against a dataset: confirmed, contradicted or undetermined.

A claim selects points, and each point is a *hit*, a *miss* or *open*. Open is what the dataset
cannot answer: a point that was not computed, or one whose class is undecided; a number that is not
known well enough, because the two ends of its interval, or of its error, say different things. The
verdict needs a number of hits (all of
the points, one, or a share): it is confirmed when the hits suffice even if every open point were a
miss, contradicted when they would not suffice even if every open point were a hit, and undetermined
in between. Open points that are no more than `HANDFUL` of them all leave the verdict to the rest;
the finding counts them.
"""

from __future__ import annotations

import json
import math
import shlex
from collections import Counter
from collections.abc import Callable, Container, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fiv_cli.analyses.catalogue import own_dims
from fiv_cli.case.case import Case, ClaimSpec
from fiv_cli.case.grammar import Bound, Bounds, OfClass, Reference, Trend
from fiv_cli.case.identity import MOTION, default_output, is_of, output_of
from fiv_cli.case.load import load_case
from fiv_cli.case.others import file_of
from fiv_cli.case.toml import toml_value
from fiv_cli.data.hdf5 import read_attributes
from fiv_cli.errors import FivError
from fiv_cli.flags import ENDED_EARLY, NOT_COMPUTED
from fiv_cli.notation.amounts import with_error
from fiv_cli.reading import select
from fiv_cli.reading.datasets import (
    analysis_of,
    class_names,
    ends_of,
    error_of,
    filled_in,
    flag_names,
    is_class,
    name_of_only,
    numbers,
    read_analyses,
    unknown_points,
)
from fiv_cli.reading.shares import ERROR, with_standard_error
from fiv_cli.reading.take import in_order, taken, without_value

Analyses = Mapping[str, xr.Dataset]
Stored = Callable[[str], Analyses]
"""Name of another case -> its analyses; SelectionError where there are none."""

_Ends = tuple[np.ndarray, np.ndarray]
_Tried = tuple[np.ndarray, np.ndarray]
"""Hits, and what is hit by one of its two ends alone."""

CONFIRMED, CONTRADICTED, UNDETERMINED = "confirmed", "contradicted", "undetermined"
NOT_RUN = "not run"
LOOKED_AT = 8  # datasets, the newest, for one of another name

UNDECIDED = "runs beside it are undecided"
BY_EIGENVALUES = (
    "where an equilibrium loses its stability, an analysis `critical` finds it, and where a cycle "
    "ends, `cycle` with `parameter`"
)

ACROSS = 2.0  # standard errors beside a share, which may be that of all starts
# Share of the points that may be open without leaving a claim undetermined that the rest decides.
HANDFUL = 0.005

# Counterexamples that a finding names; the rest is counted.
NAMED_MISSES = 3
NOTHING = "no value"
CHOSEN = "chosen by results"
END = "end"


@dataclass(frozen=True)
class Verdict:
    """What came of one claim.

    Attributes
    ----------
    verdict : "confirmed", "contradicted" or "undetermined"; "not run" where there is no dataset
    found : one line, what the dataset holds
    hits, points, open : counts of what the claim was tried on (points of the grid, values of a
        ragged variable, or steps between neighbours)
    standard_error : the greatest of the shares found, where they are over random starts alone
    """

    verdict: str
    found: str
    hits: int = 0
    points: int = 0
    open: int = 0
    standard_error: float | None = None


@dataclass(frozen=True)
class _Trial:
    """One claim tried on every point.

    Attributes
    ----------
    hit, open : masks, shape (n,); never both
    found : what the dataset holds, in words
    blurred : which of the open ones are open only for how far they may be off
    row : where each of the n lies, shape (n,); several may lie at the same place
    place : row -> its name
    noun : what is counted
    empty : which of those missed have no value to try it on, their rows
    held : the values that are as expected, in words
    between : how many are open only for what lies between two values of the axis
    """

    hit: np.ndarray
    open: np.ndarray
    found: str
    blurred: np.ndarray
    row: np.ndarray
    place: Callable[[int], str]
    noun: str = "points"
    empty: Sequence[int] = ()
    held: str = ""
    between: int = 0


@dataclass(frozen=True)
class _Numbers:
    """Numbers as far as they are known.

    Attributes
    ----------
    low, high : the least and the greatest that each was found to be; one number where it is known
    error : how far these may be off; NaN where the dataset has no word of it
    """

    low: np.ndarray
    high: np.ndarray
    error: np.ndarray

    @property
    def ends(self) -> _Ends:
        """The least and the greatest that each may be, its error counted in."""
        error = np.where(np.isnan(self.error), 0.0, self.error)
        return self.low - error, self.high + error

    @property
    def found(self) -> _Ends:
        """The same, but for the error."""
        return self.low, self.high

    def further(self, margin: float, share: float) -> _Numbers:
        """The numbers, greater by a margin and by a share of them."""
        low, high = (end + margin + share * np.abs(end) for end in self.found)
        return _Numbers(low, high, self.error * (1.0 + abs(share)))


@dataclass(frozen=True)
class _Values(_Numbers):
    """The values a claim is about, flat, with where they come from.

    Attributes
    ----------
    open : the value is not known, shape (n,)
    row : flat index of the grid point (and start) of each value, shape (n,)
    rows : array over the grid (and start) that `row` counts in C order
    """

    open: np.ndarray
    row: np.ndarray
    rows: xr.DataArray

    def trial(self, tried: _Tried, found: str, as_found: _Tried | None = None) -> _Trial:
        """Each value a hit, a miss, or open: not known, or hit by one of its ends alone.

        What comes of the values `as_found` tells which are open for their error only.
        """
        (hit, unsure), (_, open_as_found) = tried, as_found or tried
        blurred = unsure & ~open_as_found & ~self.open
        name = lambda row: point_name(self.rows, row)  # noqa: E731
        empty = self.row[np.isnan(self.low) & ~(hit | self.open | unsure)].tolist()
        found_at = _Trial(hit & ~self.open, self.open | unsure, found, blurred, self.row, name)
        return replace(found_at, empty=empty)


def held_against(case: Case, analyses: Analyses | None, missing: str = "") -> list[Verdict]:
    """The verdict of each claim of a case; `missing` says why there is no dataset."""
    if analyses is None:
        return [Verdict(NOT_RUN, missing) for _ in case.claims]
    drawn = {start.label for start in case.starts if start.kind == "random"}
    other = lambda name: _stored(name, case.source)  # noqa: E731
    verdicts = [evaluate(claim, analyses, other, drawn) for claim in case.claims]
    partial = next(iter(analyses.values())).attrs.get("partial")
    left = f"; the run has {partial}, go on with: {_command(case)}" if partial else ""
    return [replace(v, found=v.found + left) if v.verdict == UNDETERMINED else v for v in verdicts]


def dataset_of(case: Case, output: Path | None = None) -> tuple[dict[str, xr.Dataset] | None, str]:
    """What a run of the case has written, or None and why there is nothing, with what to do.

    `output` is the dataset of a run that was given one.
    """
    path = output or default_output(case)
    advice = f"compute it with: {_command(case)}" + (f" -o {output}" if output else "")
    if not path.exists():
        return None, f"{path} is not there; {_elsewhere(case, path) or advice}"
    analyses = read_analyses(path)
    attributes = next(iter(analyses.values())).attrs
    if MOTION in attributes:
        said = f"{path} holds the motion at {attributes[MOTION]}, and no sweep"
        return None, f"{said}; {_elsewhere(case, path) or advice}"
    if "\n" in str(attributes.get("history", "")):
        said = f"{path} joins several runs (api.join)"
        return None, f"{said}; from Python: api.claims(case, api.read({str(path)!r}))"
    if not is_of(attributes, case):
        advice = _as_it_was_run(analyses, case, path) or f"{advice} --fresh"
        said = f"{path} was computed from another version of the case"
        return None, f"{said}; {_elsewhere(case, path) or advice}"
    lacking = _lacking(analyses, case)
    return (None, f"{path} was computed {lacking}; {advice}") if lacking else (analyses, "")


def _lacking(analyses: Analyses, case: Case) -> str:
    """What a dataset of the case has not; empty where it has all that is asked for."""
    if len(analyses) < len(case.analyses):
        return "before an analysis was added"
    return "" if of_same_points(analyses, case) else "on another grid, or from other starts"


def _as_it_was_run(analyses: Analyses, case: Case, path: Path) -> str:
    """What to type where a dataset is of the case with what ``--set`` said when it was run."""
    attributes = next(iter(analyses.values())).attrs
    changes = str(attributes.get("overrides", "")).splitlines()
    with suppress(FivError):
        changed = load_case(case.source, changes)
        if is_of(attributes, changed) and not _lacking(analyses, changed):
            return f"it is of: {_command(changed, 'claims')} -o {path}"
    return ""


def _elsewhere(case: Case, path: Path) -> str:
    """What to type where a dataset beside `path` is the case's; empty where none is."""
    others = {other: other.stat().st_mtime for other in path.parent.glob("*.nc") if other != path}
    usual = default_output(case)
    for other in sorted(others, key=lambda one: (one != usual, -others[one]))[:LOOKED_AT]:
        with suppress(FivError, OSError):
            if is_of(read_attributes(other), case) and not _lacking(read_analyses(other), case):
                return f"{other} is of this case: {_command(case, 'claims')} -o {other}"
    return ""


def _command(case: Case, name: str = "run") -> str:
    """What to type for the dataset of a case, or for what it says."""
    files = dict.fromkeys(origin.path for origin in case.own.values() if origin.is_named)
    added = "".join(f" --with {shlex.quote(path)}" for path in files)
    changed = "".join(f" --set {shlex.quote(line)}" for line in case.overrides)
    return f"fiv {name} {case.source}{added}{changed}"


def of_same_points(analyses: Analyses, case: Case) -> bool:
    """Whether datasets have just the grid and the starts that the case asks for."""
    return all(_same_grid(case, dataset) for dataset in analyses.values())


def _same_grid(case: Case, dataset: xr.Dataset) -> bool:
    """Whether the dataset has just the points that the case asks for."""
    from_starts = "initial" in dataset.dims  # else axes of states where starts begin are not its
    axes = [axis for axis in case.axes if axis.kind != "start" or from_starts]
    asked = {axis.dim: np.asarray(axis.values) for axis in axes}
    if from_starts:
        asked["initial"] = np.asarray([label for start in case.starts for label in start.labels])
    return all(
        dim in dataset.coords and np.array_equal(dataset.coords[dim].values, values)
        for dim, values in asked.items()
    )


def _stored(case: str, source: str) -> dict[str, xr.Dataset]:
    """What another case, named in that at `source`, has found.

    Raises
    ------
    SelectionError : it has not been run, or not as it stands now
    """
    file = file_of(case, source)
    if not file.exists() and output_of(case).exists():
        return read_analyses(output_of(case))
    try:
        analyses, missing = dataset_of(load_case(file))
    except FivError as error:
        raise select.SelectionError(str(error)) from None
    if analyses is None:
        raise select.SelectionError(missing)
    return analyses


def evaluate(
    claim: ClaimSpec, analyses: Analyses, other: Stored, drawn: Container[str] = ()
) -> Verdict:
    """Hold `claim` against the analyses of its case's dataset.

    Parameters
    ----------
    claim : what is claimed
    analyses : name of the analysis -> dataset
    other : name of another case -> its analyses; SelectionError where there are none
    drawn : labels of the starts that are random

    Returns
    -------
    Verdict : never raises for what the dataset lacks; that is undetermined, and says why
    """
    if claim.undecided_counts and claim.variable != "attractor":  # numbers, as measured
        analyses = {n: one.drop_vars("attractor", errors="ignore") for n, one in analyses.items()}
    try:
        name = _holder(claim.variable, claim.analysis, analyses)
        dataset = analyses[name]
        of_results = {one: claim.at[one] for one in claim.at if one in dataset.data_vars}
        on_axes = {axis: claim.at[axis] for axis in claim.at if axis not in of_results}
        part, variable = _asked(dataset, replace(claim, at=on_axes), drawn)
        part = _narrowed(part, of_results)
        stored: Stored = lambda case: other(case) if case else analyses  # noqa: E731
        trial = _try(claim, part, variable, stored)
        if is_place := claim.take.get("what") in ("first", "last"):
            reaching = _up_to_the_next(dataset, part, claim.take)
            trial = _between(trial, _try(claim, reaching, variable, stored))
    except select.SelectionError as error:
        return Verdict(UNDETERMINED, str(error).replace("\n", "; "))
    speaks_of = select.subset(dataset, on_axes, nearest=False)
    how = in_order(claim.take, claim.at) if claim.take else {}
    lacking = without_value(speaks_of, claim.variable, how) if how else ""
    beside = filter(None, (trial.found, lacking, _of_filled(speaks_of, claim.variable)))
    trial = replace(trial, found=", ".join(beside))
    margin = float(part[ERROR].max()) if ERROR in part else 0.0
    if margin > 0.0:  # the share of a sample, and of one that is not all alike
        most = "at most " * (part[ERROR].size > 1)
        trial = replace(trial, found=f"{trial.found}, standard error {most}{margin:.2g}")
        if _is_near(claim, part, variable, stored, trial):
            near = "two of which reach across what is expected: more starts tell"
            trial = replace(trial, found=f"{trial.found}, {near}")
        if isinstance(claim.expect, Trend) and (small := _of_small_steps(claim, part, variable)):
            trial = replace(trial, found=f"{trial.found}, {small}")
    compared = isinstance(claim.expect, Bounds) and bool(claim.expect.references)
    told = _why_empty(trial, part), _why_open(trial, part, compared and not claim.take)
    verdict = _judge(trial, claim.holds, ", ".join(filter(None, told)))
    if of_results and not verdict.points:
        asked = ", ".join(f"{one} = {json.dumps(of_results[one])}" for one in of_results)
        verdict = replace(verdict, found=f"{verdict.found}: no value has {asked}")
    hint = ""
    if verdict.verdict != CONFIRMED:
        hint = _hint(verdict, part, variable) + _fewer_crossings(part, claim.at)
    if verdict.verdict == UNDETERMINED and trial.blurred.sum() > trial.between:
        more = _sharpened(name, dataset, part.get(f"{variable}_width"))
        hint = f", {more}{hint}"
    is_missed = verdict.verdict == CONTRADICTED and bool(part[variable].notnull().any())
    if is_place and (trial.between or is_missed):
        hint += _steps_between(dataset, claim.take)
    of_share = margin if margin > 0.0 else None
    return replace(verdict, found=f"{verdict.found}{hint}", standard_error=of_share)


def _try(claim: ClaimSpec, part: xr.Dataset, variable: str, stored: Stored) -> _Trial:
    """What is expected, tried on every value."""
    match claim.expect:
        case OfClass():
            trial = _try_class(claim.expect, part, variable)
        case Trend():
            trial = _try_trend(claim.expect, part, variable)
        case Bounds():
            trial = _try_bounds(claim.expect, part, variable, claim.at, stored)
    at_end = END in part.attrs and bool((part[variable] == part.attrs[END]).any())
    return replace(trial, found=f"{trial.found} (an end of the axis)") if at_end else trial


def _is_near(
    claim: ClaimSpec, part: xr.Dataset, variable: str, stored: Stored, found: _Trial
) -> bool:
    """Whether shares that two of their standard errors lie beside would be told otherwise."""
    names = [f"{variable}{end}" for end in ("", "_low", "_high") if f"{variable}{end}" in part]
    shifted = (
        part.assign({name: _beside(part[name], off * part[ERROR]) for name in names})
        for off in (-ACROSS, ACROSS)
    )
    trials = (_try(claim, one, variable, stored) for one in shifted)
    return any(bool((one.hit != found.hit).any()) for one in trials)


def _of_small_steps(claim: ClaimSpec, part: xr.Dataset, variable: str) -> str:
    """How many steps of a share that go the wrong way are none, or within two standard errors."""
    dim = str(_one_axis(part).dims[0])
    values, variance = part[variable], part[ERROR] ** 2
    step = values.diff(dim) * (1.0 if claim.expect == Trend(rises=True) else -1.0)
    error = np.sqrt(variance.isel({dim: slice(1, None)}).values + variance[{dim: slice(-1)}].values)
    within = int(((step < 0.0) & (-step.values <= ACROSS * error)).sum())
    none = int((step == 0.0).sum())
    told = {f"{within} the other way by less than two of these": within, f"{none} of none": none}
    return ", ".join(word for word, count in told.items() if count)


def _beside(share: xr.DataArray, off: xr.DataArray) -> xr.DataArray:
    """A share so far off, neither 0 nor 1: one start of a class, and one without, are certain."""
    within = np.finfo(float).tiny, 1.0 - np.finfo(float).eps
    return (share + off).clip(*within).where((off != 0.0) & (share > 0.0) & (share < 1.0), share)


def _of_filled(part: xr.Dataset, variable: str) -> str:
    """How many points of a refined map were run, where what is said of them is filled in."""
    filled, size = int(filled_in(part, variable).sum()), part["status"].size
    return f"{size - filled} of {size} run, others filled in" if filled else ""


def _narrowed(part: xr.Dataset, results: Mapping[str, Any]) -> xr.Dataset:
    """The part with a mask of the values at which results have the classes that are wanted."""
    chosen = xr.DataArray(True)
    for name, wanted in results.items():
        classes = tuple(map(str, wanted)) if isinstance(wanted, list) else (str(wanted),)
        chosen = chosen & is_class(part[name], classes)
    return part.assign({CHOSEN: chosen})


def _hint(verdict: Verdict, part: xr.Dataset, variable: str) -> str:
    """Why there is nothing to try a claim on, or that it was tried on several values of a point."""
    if verdict.points == 0:
        reasons = dict.fromkeys(class_names(part.get("reason", part["status"])))
        told = ", ".join(name for name in reasons if name not in ("none", "ok"))
        return f": {told} (fiv show says what it means)" if told else ""
    if verdict.points == verdict.open and _has_undecided(part):
        counted = '; undecided = "counts" in the claim takes what was measured of them until t_max'
        return f": fiv show says what helps{counted if variable != 'attractor' else ''}"
    own = [dim for dim in part[variable].dims if dim not in part["status"].dims]
    several = set(own) <= set(own_dims()) and numbers(part[variable]).notnull().sum(own) > 1
    if not own or not np.any(several) or verdict.verdict == UNDETERMINED:
        return ""
    first = select.axis_of(part, str(own[0])).values[:1].tolist()
    return f", several at a point: at = {{ {own[0]} = {json.dumps(*first)} }} takes the first"


def _fewer_crossings(part: xr.Dataset, at: Mapping[str, Any]) -> str:
    """That points have no crossing of the number that a claim asks for; empty where all do."""
    wanted = at.get("crossing")
    if not isinstance(wanted, int) or "n_crossings" not in part:
        return ""
    few = is_class(part["status"], ("ok",)) & (part["n_crossings"] <= wanted)
    number, points = int(few.sum()), few.size
    return f", {number} of {points} have no crossing {wanted} (n_crossings)" if number else ""


def _has_undecided(part: xr.Dataset) -> bool:
    return "attractor" in part and bool(is_class(part["attractor"], ("undecided",)).any())


def _asked(
    dataset: xr.Dataset, claim: ClaimSpec | Reference, drawn: Container[str] = ()
) -> tuple[xr.Dataset, str]:
    """The part of the dataset that a claim is about, and the variable of it.

    What `at` says of axes along which something is taken says of what; the rest selects results.
    """
    if not claim.take:
        return select.subset(dataset, claim.at, nearest=False), claim.variable
    over = {name.replace(".", "_") for name in claim.take["over"]}
    inner = {name: at for name, at in claim.at.items() if name.replace(".", "_") in over}
    outer = {name: at for name, at in claim.at.items() if name not in inner}
    part = select.subset(dataset, inner, nearest=False)
    how = in_order(claim.take, inner)
    found = taken(part, claim.variable, how).assign_attrs(_ends(part, claim.take))
    found = with_standard_error(found, part, claim.take, drawn)
    return select.subset(found, outer, nearest=False), claim.take["what"]


def _ends(part: xr.Dataset, take: Mapping[str, Any]) -> dict[str, Any]:
    """The end of the axis that a first or last place may lie at, and then is no border."""
    end = {"first": 0, "last": -1}.get(take["what"])
    return {} if end is None else {END: select.axis_of(part, *take["over"]).values[end]}


def _between(trial: _Trial, onward: _Trial) -> _Trial:
    """A trial of places of which some may lie elsewhere up to the next value of the axis."""
    between = ~trial.open & (onward.open | (onward.hit != trial.hit))
    hit, blurred = trial.hit & ~between, trial.blurred | between
    return replace(
        trial, hit=hit, open=trial.open | between, blurred=blurred, between=int(between.sum())
    )


def _up_to_the_next(dataset: xr.Dataset, part: xr.Dataset, take: Mapping[str, Any]) -> xr.Dataset:
    """First or last places as intervals: to the next value of the axis, which is none, or its end.

    What holds to the end of the axis may hold beyond.
    """
    what, axis = take["what"], select.axis_of(dataset, *take["over"])
    along = axis.values if what == "last" else axis.values[::-1]
    beyond = math.copysign(math.inf, along[-1] - along[0])
    following = dict(zip(along, np.nextafter([*along[1:], beyond], along), strict=True))
    ends = ends_of(part, what)
    onward = [
        xr.apply_ufunc(np.vectorize(lambda x: following.get(x, x), otypes=[float]), end)
        for end in ends
    ]
    low, high = np.fmin(*ends), np.fmax(*ends)
    return part.assign(
        {
            f"{what}_low": np.fmin(low, np.fmin(*onward)),
            f"{what}_high": np.fmax(high, np.fmax(*onward)),
        }
    )


def _steps_between(dataset: xr.Dataset, take: Mapping[str, Any]) -> str:
    """How far values of the axis lie apart along which a first or last one was taken."""
    axis = select.axis_of(dataset, *take["over"])
    if axis.size < 2 or not select.is_numeric(axis):
        return ""
    step = float(np.abs(np.diff(axis.values)).max())
    finder = "critical" if "eigenvalue_real" in dataset else "boundary"
    return f"; {axis.name} goes in steps of {step:.4g}: a `{finder}` finds what lies between"


def _sharpened(analysis: str, dataset: xr.Dataset, reached: xr.DataArray | None) -> str:
    """What lessens the error of numbers of an analysis that were bisected to these widths."""
    settings = analysis_of(dataset, analysis).get("settings", {})
    called = analysis or name_of_only(dataset)
    if "width" not in settings:
        return "no setting of the analysis lessens it; allow for it in `expect`"
    if reached is not None and bool(wider_than_asked(dataset, settings, reached).any()):
        return f"{BY_EIGENVALUES}; {beside(dataset)} of the analysis {called!r} lessens it"
    return f"a smaller `width` of the analysis {called!r} lessens it"


def beside(dataset: xr.Dataset, wide: xr.DataArray | bool = True) -> str:
    """What lies beside `wide` changes of a `boundary`, and which setting lets it have an answer."""
    known = [dataset[name] for name in ("class_below", "class_above") if name in dataset]
    sides = [one.where(wide) for one in known]
    lost = [one for side in sides for one in ENDED_EARLY if bool(is_class(side, (one,)).any())]
    if not lost:
        why = dataset.get("undecided_reason", dataset["status"])  # 0.1.0 does not say
        if bool((is_class(why, ("cycle_not_confirmed",)) & wide).any()):
            return f"{UNDECIDED} (cycle_not_confirmed): a smaller `solver.rtol` or larger `t_max`"
        return f"{UNDECIDED}: a larger `t_max`, else a smaller `solver.rtol`"
    ended = " and ".join(dict.fromkeys(lost)).replace("_", " ")
    return f"runs beside it ended ({ended}), without a number: asking for a class in `of`"


def wider_than_asked(
    dataset: xr.Dataset, settings: Mapping[str, Any], reached: xr.DataArray
) -> xr.DataArray:
    """Where runs without an answer kept a `boundary` from the width that was asked for."""
    asked = settings["width"] * np.ptp(settings.get("bracket", ()) or 0.0)
    return (reached > 2.0 * asked) & ("n_undecided" in dataset)


def _holder(variable: str, analysis: str, analyses: Analyses) -> str:
    """The name of the analysis that has a variable: the one that is named, or the first."""
    if analysis and list(analyses) == [""] and analysis == name_of_only(analyses[""]):
        analysis = ""  # a file of one analysis does not say its name
    if analysis and analysis not in analyses:
        raise select.SelectionError(f"{analysis}: no analysis of the dataset")
    for name in [analysis] if analysis else analyses:
        if variable in analyses[name].variables:
            return name
    raise select.SelectionError(f"{variable}: no variable of the dataset")


def _judge(trial: _Trial, holds: str | float, why_open: str) -> Verdict:
    """From hits, misses and open points to a verdict."""
    points, hits, unknown = trial.hit.size, int(trial.hit.sum()), int(trial.open.sum())
    if points == 0:
        return Verdict(UNDETERMINED, "nothing to try it on")
    handful = unknown <= HANDFUL * points
    needed = _needed(holds, points - unknown if handful else points)
    verdict = UNDETERMINED
    if hits >= needed:
        verdict = CONFIRMED
    elif handful or hits + unknown < needed:
        verdict = CONTRADICTED
    if holds == "any" and trial.held and 0 < hits < points:
        trial = replace(trial, found=f"{trial.found}, {trial.held}")
    return Verdict(verdict, _finding(trial, hits, points, why_open), hits, points, unknown)


def _needed(holds: str | float, points: int) -> int:
    """Hits that confirm a claim on so many points."""
    if holds == "all":
        return points
    if holds == "any":
        return 1
    # 0.9 of 10 is 9 points, not 9.000000000000002
    return math.ceil(round(float(holds) * points, 9))


def _finding(trial: _Trial, hits: int, points: int, why_open: str) -> str:
    parts = [f"{hits} of {points} {trial.noun}", trial.found, why_open]
    blurred = int(trial.blurred.sum()) - trial.between
    if blurred:
        parts.append(f"{blurred} not known well enough: the error reaches past what is expected")
    if trial.between:
        beside = "up to the value of the axis before it, or after a last one"
        parts.append(f"{trial.between} may lie anywhere {beside}")
    parts.append(_where_missed(trial))
    return ", ".join(part for part in parts if part)


def _why_open(trial: _Trial, part: xr.Dataset, compared: bool) -> str:
    """How many have no answer, and the reasons of their points, or else their status.

    Those without either lack an answer in what they are `compared` with, if they are.
    """
    rows = trial.row[trial.open & ~trial.blurred]
    if not rows.size:
        return ""
    told, status = f"{rows.size} not decided or not computed", class_names(part["status"])
    if trial.noun != "points":
        return told
    reasons = class_names(part["reason"]) if "reason" in part else status
    named = np.where(np.isin(reasons, ("", "none", NOT_COMPUTED)), status, reasons)[rows]
    counts = Counter(named[~np.isin(named, ("ok", ""))].tolist())
    listed = [f"{name} {count}" for name, count in counts.most_common()]
    if compared and counts.total() < rows.size:
        listed.append(f"{rows.size - counts.total()} in what it is compared with")
    return f"{told} ({', '.join(listed)})" if listed else told


def _why_empty(trial: _Trial, part: xr.Dataset) -> str:
    """How many of those missed have no value, and their classes."""
    if not trial.empty:
        return ""
    classes = Counter(class_names(part.get("attractor", part["status"]))[trial.empty].tolist())
    listed = ", ".join(f"{name} {count}" for name, count in classes.most_common())
    return f"{len(trial.empty)} have none ({listed}): narrow `at` to those that have one"


def _where_missed(trial: _Trial) -> str:
    """The first places that were missed by name, the rest by number."""
    missed = np.unique(trial.row[~trial.hit & ~trial.open])
    named = "; ".join(filter(None, (trial.place(int(row)) for row in missed[:NAMED_MISSES])))
    rest = missed.size - NAMED_MISSES
    return f"not at {named}" + (f" and {rest} more" if rest > 0 else "") if named else ""


def _try_class(expect: OfClass, part: xr.Dataset, variable: str) -> _Trial:
    """A class name, or ``not CLASS``."""
    values = _values(part, variable, allow_undecided=expect.name == "undecided")
    classes = flag_names(part[variable].attrs)
    if expect.name not in classes.values():
        allowed = ", ".join(classes.values()) or "none: it is no flag"
        raise select.SelectionError(f"{expect.name}: no class of {variable} ({allowed})")
    codes = [code for code, name in classes.items() if name == expect.name]
    hit = np.isin(values.low, codes) != expect.negated
    counts = Counter(values.low[~values.open].tolist())
    named = [f"{classes.get(code, code)} {count}" for code, count in counts.most_common()]
    tried = hit, np.zeros_like(hit)
    return values.trial(tried, "found " + ", ".join(named) if named else "")


def _try_bounds(
    expect: Bounds, part: xr.Dataset, variable: str, at: Mapping[str, Any], stored: Stored
) -> _Trial:
    """Each value lies between numbers, or beside what is found elsewhere at the same point."""
    values = _values(part, variable)
    least, greatest = (_bound(end, at, values, stored) for end in (expect.least, expect.greatest))
    bounds = (least, greatest)
    against = dict.fromkeys(
        f"against {_named(said)}: {_span(bound)}"
        for said, bound in zip((expect.least, expect.greatest), bounds, strict=True)
        if isinstance(said, Reference)
    )
    if expect.margin or expect.share:
        least = least.further(-expect.margin, -expect.share)
        greatest = greatest.further(expect.margin, expect.share)
    tried = _within(values.ends, least.ends, greatest.ends, expect.strict)
    as_found = _within(values.found, least.found, greatest.found, expect.strict)
    found = ", ".join([f"found {_range(values, part[variable])}", *against])
    trial = values.trial(tried, found, as_found)
    return replace(trial, held=f"as expected: {_range(values, part[variable], trial.hit)}")


def _named(said: Reference) -> str:
    """What a claim compares with, whole, as a case writes it."""
    given = {key: value for key, value in vars(said).items() if value not in ("", {}, None, 1.0)}
    return said.variable if [*given] == ["variable"] else toml_value(given, "claim")


def _within(value: _Ends, least: _Ends, greatest: _Ends, strict: bool) -> _Tried:
    """Which numbers lie between bounds, and which may or may not, of each the two ends."""
    above, below = (np.greater, np.less) if strict else (np.greater_equal, np.less_equal)
    hit = above(value[0], least[1]) & below(value[1], greatest[0])
    may_be = above(value[1], least[0]) & below(value[0], greatest[1])
    return hit, np.isnan(least[0]) | np.isnan(greatest[0]) | (may_be & ~hit)


def _bound(bound: Bound, at: Mapping[str, Any], values: _Values, stored: Stored) -> _Numbers:
    """A number, or what is referred to at the point of each value found, else NaN."""
    if not isinstance(bound, Reference):
        return _Numbers(np.array(bound), np.array(bound), np.array(0.0))
    analyses = stored(bound.case)
    dataset = analyses[_holder(bound.variable, bound.analysis, analyses)]
    dims = {name: select.axis_of(dataset, name).dims[0] for name in select.axis_names(dataset)}
    own = [dims.get(name.replace(".", "_")) for name in bound.at]
    shared = {n: at[n] for n in at if dims.get(n.replace(".", "_")) not in (None, *own)}
    try:
        part, variable = _asked(dataset, replace(bound, at={**shared, **bound.at}))
    except select.SelectionError as error:
        whose = bound.case or bound.analysis or bound.variable
        raise select.SelectionError(f"what is compared with, {whose}: {error}") from None
    # an axis has its values whatever becomes of the points there
    known = variable in part.coords or ~unknown_points(part, variable, False)
    told = (*ends_of(part, variable), _errors(part, variable))
    arrays = (_at_points_of(bound.times * one.where(known), values.rows, own) for one in told)
    return _Numbers(*(np.asarray(one.values.ravel()[values.row]) for one in arrays))


def _try_trend(expect: Trend, part: xr.Dataset, variable: str) -> _Trial:
    """Each step along the one axis left goes the right way; labels are lines of their own."""
    axis = _one_axis(part)
    if axis.dims[0] not in part[variable].dims:
        raise select.SelectionError(f"{variable}: not one value per point along {axis.dims[0]}")
    known = ~unknown_points(part, variable, False)
    low, high = (end.where(known & np.isfinite(end)) for end in ends_of(part, variable))
    error = _errors(part, variable).fillna(0.0)
    (hit, unsure), (_, open_as_found) = (
        _steps(low - by, high + by, str(axis.dims[0]), expect.rises) for by in (error, 0.0)
    )
    return _Trial(
        hit,
        unsure,
        f"found {_range(_values(part, variable), part[variable])}",
        unsure & ~open_as_found,
        np.arange(hit.size),
        lambda step: _step_name(axis, step),
        "steps",
    )


def _steps(low: xr.DataArray, high: xr.DataArray, dim: str, rises: bool) -> _Tried:
    """Which steps along `dim` go the right way, line after line, and which may.

    These are such as have an end without a value, or ends that overlap.
    """
    lows, highs = (end.transpose(..., dim).values for end in (low, high))
    least, greatest = lows[..., 1:] - highs[..., :-1], highs[..., 1:] - lows[..., :-1]
    if not rises:
        least, greatest = -greatest, -least
    unsure = np.isnan(least) | ((least <= 0.0) & (greatest > 0.0))
    return (least > 0.0).ravel(), unsure.ravel()


def _step_name(axis: xr.DataArray, step: int) -> str:
    """A step by its ends; steps are counted line after line."""
    begin = step % (axis.size - 1)
    return f"{axis.name} = {axis.values[begin]:g} to {axis.values[begin + 1]:g}"


def _one_axis(part: xr.Dataset) -> xr.DataArray:
    """The single numeric axis along which anything is left to vary."""
    axes = [select.axis_of(part, str(name)) for name in part.coords if part.coords[name].ndim == 1]
    left = {
        str(axis.dims[0]): axis
        for axis in axes
        if axis.size > 1 and select.is_numeric(axis) and str(axis.dims[0]) in part["status"].dims
    }
    if len(left) != 1:
        names = ", ".join(left) or "none"
        raise select.SelectionError(
            f"one numeric axis must be left to vary, found: {names}; narrow it with `at`"
        )
    return next(iter(left.values()))


def _at_points_of(
    array: xr.DataArray, points: xr.DataArray, own: Sequence[Hashable]
) -> xr.DataArray:
    """`array` at the coordinates of `points`: NaN where it has no such point.

    Along its `own` dims it stands at one place, whatever that of the points.
    """
    for dim in map(str, array.dims):
        axis, is_one = array.coords.get(dim), array.sizes[dim] == 1
        # the one start of the other case stands for whatever start this case has
        is_label = is_one and axis is not None and not select.is_numeric(axis)
        if dim not in points.dims or dim in own or is_label:
            if not is_one:
                message = (
                    f"{dim}: an axis of what it is compared with, and none of the claim's own "
                    "(axes are one by their names, and zipped alike); narrow it to one in its `at`"
                )
                raise select.SelectionError(message)
            array = array.isel({dim: 0}, drop=True)
        elif axis is not None and select.is_numeric(axis):
            wanted = points.coords[dim].values
            tolerance = select.SAME * float(np.max(np.abs(wanted)))
            array = array.reindex({dim: wanted}, method="nearest", tolerance=tolerance)
        elif axis is not None:
            array = array.reindex({dim: points.coords[dim].values})
    return xr.broadcast(array, points)[0].transpose(*points.dims)


def _values(part: xr.Dataset, variable: str, allow_undecided: bool = False) -> _Values:
    """Every value of `variable` in `part`; padding along its own dims is left out."""
    rows = part["status"]
    sizes = select.row_sizes(part, variable)
    if sizes is not None:
        return _ragged_values(part, variable, sizes)
    row = rows.copy(data=np.arange(rows.size).reshape(rows.shape))
    unknown = unknown_points(part, variable, allow_undecided)
    told = (*ends_of(part, variable), _errors(part, variable), unknown, row, _chosen(part))
    flat = (a.transpose(*rows.dims, ...).values.ravel() for a in xr.broadcast(*told))
    low, high, error, is_open, place, chosen = flat
    padded = not set(part[variable].dims) <= set(rows.dims)
    kept = is_open | (chosen & (~np.isnan(low) | (not padded)))
    return _Values(low[kept], high[kept], error[kept], is_open[kept], place[kept], rows)


def _errors(part: xr.Dataset, variable: str) -> xr.DataArray:
    """How far each value may be off, any distance where that was not found; NaN: nothing said."""
    error = part.get(error_of(variable))
    return xr.DataArray(np.nan) if error is None else error.fillna(math.inf)


def _chosen(part: xr.Dataset) -> xr.DataArray:
    """Which values a claim is narrowed to by results; all, unless `_narrowed` says otherwise."""
    return part.get(CHOSEN, xr.DataArray(True))


def _ragged_values(part: xr.Dataset, variable: str, sizes: xr.DataArray) -> _Values:
    """Observations of every row; a row that is not known stands as one open value."""
    rows = part["status"]
    unknown = unknown_points(part, variable, False).values.ravel()
    row = select.row_of_each(sizes.transpose(*rows.dims))
    chosen = _chosen(part)
    of_points = set(chosen.dims) <= set(rows.dims)
    among = chosen.broadcast_like(rows).values.ravel()[row] if of_points else chosen.values
    known = ~unknown[row] & among
    open_rows = np.flatnonzero(unknown)
    none, errors = np.full(open_rows.size, np.nan), _errors(part, variable)
    values = np.concatenate([part[variable].values[known], none])
    error = np.concatenate([errors.broadcast_like(part[variable]).values[known], none])
    is_open = np.arange(values.size) >= known.sum()
    return _Values(values, values, error, is_open, np.concatenate([row[known], open_rows]), rows)


def _range(values: _Values, variable: xr.DataArray, among: np.ndarray | bool = True) -> str:
    """The values that are known, of some or all, from least to greatest, with their unit."""
    unit = str(variable.attrs.get("units", "1"))
    span = _span(values, ~values.open & among)
    return span if unit == "1" or span == NOTHING else f"{span} {unit}"


def _span(numbers: _Numbers, among: np.ndarray | bool = True) -> str:
    known = np.isfinite(numbers.low) & np.isfinite(numbers.high) & among
    if not known.any():
        return NOTHING
    low, high, error = (one[known] for one in (numbers.low, numbers.high, numbers.error))
    ends = ((low, low.argmin()), (high, high.argmax()))
    return " to ".join(dict.fromkeys(with_error(end[at], error[at]) for end, at in ends))


def point_name(points: xr.DataArray, row: int) -> str:
    """Where the flat (C order) index `row` lies on the axes of `points` that vary."""
    place = np.unravel_index(row, points.shape) if points.ndim else ()
    return ", ".join(
        f"{name} = {_shown(coord.values[index])}"
        for dim, index in zip(points.dims, place, strict=True)
        if points.sizes[dim] > 1
        for name, coord in points.coords.items()
        if coord.dims == (dim,)
    )


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float | np.floating) else str(value)


def tally(verdicts: list[str]) -> str:
    """``3 confirmed, 1 contradicted`` from a list of verdicts, most decided first."""
    order = (CONFIRMED, CONTRADICTED, UNDETERMINED, "not run")
    counts = Counter(verdicts)
    named = [f"{counts[name]} {name}" for name in order if counts[name]]
    return ", ".join(named) or "no claims"
