"""Which results belong together: fingerprints of cases and names of outputs.

A case's fingerprint hashes everything that decides its numbers but the extent of the grid, so that
an axis may grow and finished points stay, as they do where a start or an analysis is added. Titles,
claims and figures do not count. The keys of points are built on it in ``sweep/requests.py``.
"""

from __future__ import annotations

import json
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import asdict, is_dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from fiv_cli.analyses import get_analysis
from fiv_cli.case.case import AnalysisSpec, Case, StartSpec
from fiv_cli.case.overrides import parse_override
from fiv_cli.case.report import dotted
from fiv_cli.codegen import NUMERICS_VERSION
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

DOCUMENT_VERSION = 1
STEADY_STATE = "steady_state"  # attribute of a motion that begins in one: which
MOTION = "point"  # global attribute that only the motion of a single point has
FOLLOWING_VERSION = 2  # raised whenever what is followed in steps is lost elsewhere


def document(
    case: Case, analyses: Sequence[AnalysisSpec] = (), starts: Container[str] | None = None
) -> dict[str, Any]:
    """What decides the numbers of a case but the extent of its grid, as plain JSON values.

    Parameters
    ----------
    case : the case
    analyses : only these; none: all of them
    starts : only those with these labels; None: all of them
    """
    varied = {axis.name for axis in case.axes}
    analyses = analyses or case.analyses
    with_starts = any(get_analysis(spec.kind).uses_starts for spec in analyses)
    told = [one for one in case.starts if with_starts and (starts is None or one.label in starts)]
    found = {
        "document": DOCUMENT_VERSION,
        "model": case.model,
        "options": {k: v for k, v in _told_options(case).items() if k not in varied},
        "law": "an axis" if _law_varies(case) else case.law,
        "parameters": _deciding_parameters(case),
        "axes": [[axis.name, axis.kind] for axis in case.axes],
        "zip": case.zips,
        "starts": {start.label: _start(start) for start in told},
        "analyses": {spec.name: replace(spec, settings=spec.told) for spec in analyses},
        "solver": case.solver,
        "numerics": _numerics(case, analyses, told),
    }
    own = _deciding_texts(case)
    if own:
        found["own"] = own
    if case.schedule.curves:  # only then: the keys of a constant case are what they were
        found["schedule"] = dict(case.schedule.curves)
    return json.loads(json.dumps(found, default=_plain))


def _start(start: StartSpec) -> dict[str, Any]:
    """A start; for the rows of a table stands their hash, and nothing where it has none.

    How many random ones there are is no more than the extent of a grid.
    """
    facts = asdict(start)
    if start.kind == "random":
        del facts["count"]
    rows = facts.pop("rows")
    return facts | ({"rows": _hash(rows)} if rows else {})


def fingerprint(
    case: Case, analyses: Sequence[AnalysisSpec] = (), starts: Container[str] | None = None
) -> str:
    """Hash of `document`, 64 hexadecimal digits."""
    return _hash(document(case, analyses, starts))


def named_in(stored: object, case: Case) -> list[AnalysisSpec]:
    """The analyses of `case` among those stored, by name: an analysis may be added to a case."""
    return [spec for spec in case.analyses if isinstance(stored, dict) and spec.name in stored]


def is_of(attributes: Mapping[str, Any], case: Case) -> bool:
    """Whether the dataset with these attributes is of `case`, or was before it was added to.

    What may be added to a case are analyses and starts. A single motion of it is none of a sweep.
    """
    if MOTION in attributes:
        return False
    stored = named_in(_object(attributes, "analyses_json"), case)
    starts = _object(attributes, "starts_json")
    return str(attributes.get("fingerprint")) == fingerprint(case, stored, starts)


def _object(attributes: Mapping[str, Any], name: str) -> dict[str, Any] | None:
    """What an attribute tells as JSON; None where it is not there, or damaged."""
    try:
        found = json.loads(str(attributes.get(name)))
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def differences(stored: Mapping[str, Any], case: Case) -> list[str]:
    """How a stored `document` and that of `case` differ, one line each; [] when they do not.

    Of the case only the analyses and starts that are stored: what is added to them changes nothing
    of theirs.
    """
    now = document(case, named_in(stored.get("analyses"), case), stored.get("starts", ()))
    was, own = dict(stored.get("own", {})), now.get("own", {})
    changed = sorted(name for name in was.keys() & own.keys() if was[name] != own[name])
    was |= {name: own[name] for name in changed}
    told = [f"{name}: {case.own[name].path} was changed since" for name in changed]
    return told + list(_compare({**stored, **({"own": was} if was else {})}, now, ""))


def digest(overrides: Sequence[str]) -> str:
    """Eight hexadecimal digits that tell sets of ``--set`` lines apart by what they set."""
    parsed = [parse_override(override) for override in overrides]
    return _hash({dotted(one.keys): repr(one.value) for one in parsed})[:8]


def default_output(case: Case) -> Path:
    """``runs/STEM.nc``, or ``runs/STEM-DIGEST.nc`` when there are overrides."""
    return output_of(case.source, f"-{digest(case.overrides)}" if case.overrides else "")


def output_of(source: str | Path, suffix: str = "") -> Path:
    """Where the dataset of the case file `source` goes unless the user says otherwise."""
    return Path("runs") / f"{Path(source).stem}{suffix}.nc"


def _told_options(case: Case) -> dict[str, str]:
    """The options without those that came later and are at their default."""
    later = {one.name: one.default for one in get_model(case.model).options if one.later}
    return {name: value for name, value in case.options.items() if value != later.get(name)}


def _deciding_parameters(case: Case) -> dict[str, Any]:
    """The fixed parameters; of laws on an axis what the case gives: the rest is the points'."""
    if not _law_varies(case):
        return dict(case.parameters)
    own = [parameter.name for parameter in get_model(case.model).parameters]
    decided = {*own, *(name.split(".")[-1] for name in case.explicit)}
    fixed = case.parameters.items()
    return {name: value for name, value in fixed if name.split(".")[-1] in decided}


def _law_varies(case: Case) -> bool:
    return any(axis.kind == "law" for axis in case.axes)


def _deciding_texts(case: Case) -> dict[str, str]:
    """Hashes of its model and its law from outside; those of laws on an axis are the points'."""
    deciding = (case.model, *(() if _law_varies(case) else (case.law,)))
    return {name: case.own[name].digest for name in deciding if name in case.own}


def _numerics(
    case: Case, analyses: Sequence[AnalysisSpec], starts: Sequence[StartSpec]
) -> dict[str, int]:
    """The numerics versions that these analyses of the case, from these starts, depend on."""
    laws = () if _law_varies(case) else (case.law,)
    own = {"engine": NUMERICS_VERSION, "model": get_model(case.model).numerics_version}
    if any(_follows(spec, starts) for spec in analyses):
        own["following"] = FOLLOWING_VERSION
    return own | {law: get_law(law).numerics_version for law in laws}


def _follows(spec: AnalysisSpec, starts: Sequence[StartSpec]) -> bool:
    """Whether an analysis follows a class in steps, along its bracket or along the grid."""
    chains = any(one.kind == "continue" for one in starts)
    along_grid = chains and get_analysis(spec.kind).uses_starts
    return along_grid or spec.settings.get("follow", "none") != "none"


def _hash(facts: object) -> str:
    text = json.dumps(facts, sort_keys=True, default=_plain, separators=(",", ":"))
    return sha256(text.encode()).hexdigest()


def _plain(value: Any) -> Any:
    """A dataclass or mapping as JSON values; floats are written with all their digits."""
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{value!r} has no place in an identity")


def _compare(stored: Any, now: Any, place: str) -> Iterable[str]:
    if place.endswith(".section") and stored != now:
        yield f"{place}: stored {section_as_written(stored)}, now {section_as_written(now)}"
    elif isinstance(stored, dict) and isinstance(now, dict):
        for key in sorted(stored.keys() | now.keys()):
            yield from _compare_key(stored, now, key, f"{place}.{key}" if place else key)
    elif stored != now:
        yield f"{place}: stored {json.dumps(stored)}, now {json.dumps(now)}"


def _compare_key(
    stored: dict[str, Any], now: dict[str, Any], key: str, place: str
) -> Iterable[str]:
    if key not in now:
        yield f"{place}: stored{_shown(stored[key])}, now absent"
    elif key not in stored:
        yield f"{place}: now{_shown(now[key]) or ' there'}, absent in what is stored"
    else:
        yield from _compare(stored[key], now[key], place)


def section_as_written(section: Mapping[str, Any]) -> str:
    """A stored section as a case writes it; one that names none has that of any event."""
    if section["kind"] == "own":
        return '{ event = "any" }, as where a case names none'
    told = {"event": ("event", "contact"), "zero": ("state", "direction"), "phase": ("phase",)}
    names = {"state": "zero"}
    pairs = [(names.get(key, key), section[key]) for key in told[section["kind"]]]
    return f"{{ {', '.join(f'{name} = {json.dumps(value)}' for name, value in pairs)} }}"


def _shown(value: Any) -> str:
    """A single value; of a whole table its name says enough."""
    return "" if isinstance(value, dict) else f" {json.dumps(value)}"
