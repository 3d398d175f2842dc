"""One line in place of those of several starts, or places, that would hide one another."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from fiv_cli.plots import points
from fiv_cli.plots.curve_lines import Curve

MOSTLY = 0.9  # of their points, at which lines of all starts are one, but for what each has alone
MOST_COMPARED = 100  # lines that may lie on one another


def each_once(drawn: Sequence[tuple[int, Curve]]) -> list[tuple[int, Curve]]:
    """The same (panel, line), with one in place of a few that would hide one another."""
    if len(drawn) > MOST_COMPARED:
        return [*drawn]
    starts = {*filter(None, (one.words.get("initial") for _, one in drawn))}
    parted = [*_parted(drawn, starts)]
    groups: list[list[int]] = []
    for number, (place, one) in enumerate(parted):
        firsts = (group for group in groups if parted[group[0]][0] == place)
        group = next((own for own in firsts if one.hides(parted[own[0]][1])), None)
        if group is None:
            groups.append([number])
        else:
            group.append(number)
    alike = [[parted[number] for number in group] for group in groups]
    called = chain(parted, *(_as_one(group, starts) for group in alike))
    by_name = all(one.words.get("initial") not in points.SHARED for _, one in called)
    found: dict[int, tuple[int, Curve]] = {}
    for group, own in zip(groups, alike, strict=True):
        # what stays apart keeps its place, and with it its colour
        found |= zip(group, _as_one(own, starts, by_name), strict=False)
    return [found[number] for number in sorted(found)]


def _parted(
    drawn: Sequence[tuple[int, Curve]], starts: Collection[str]
) -> Iterator[tuple[int, Curve]]:
    """The same (panel, line); what all `starts` share of lines that are one nearly everywhere once.

    Of each such line there is what it has for itself then.
    """
    alike: dict[tuple[int, str], list[Curve]] = {}
    for place, one in drawn:
        alike.setdefault((place, one.without("initial")), []).append(one)
    shared = [_shared(own, starts) for own in alike.values()]
    if not MOSTLY <= min((share for _, share in shared), default=1.0) < 1.0:
        yield from drawn
        return
    for ((place, _), own), (part, _) in zip(alike.items(), shared, strict=True):
        called = {**own[0].words, "initial": points.SHARED[len(starts) > 2]}
        names = tuple(one.label for one in own)
        if not part.any():
            yield from ((place, one) for one in own)
            continue
        yield place, replace(own[0].only(part), words=called, names=names, way=np.zeros(0))
        yield from ((place, one.only(~part)) for one in own if (one.known & ~part).any())


def _shared(own: Sequence[Curve], starts: Collection[str]) -> tuple[np.ndarray, float]:
    """At which points lines of several starts are one, and at what share of those with a value.

    Of what is no line of a start, none.
    """
    plain = all("initial" in one.words and not one.is_random for one in own)
    if not plain or len(own) != len(starts) or not all(one.can_hide(own[0]) for one in own):
        return np.zeros(1, bool), 0.0
    known = np.any([one.known for one in own], axis=0)
    part = known & np.all([one.agrees_with(own[0]) for one in own], axis=0)
    return part, float(part.sum() / known.sum()) if known.any() else 1.0


def _as_one(
    group: list[tuple[int, Curve]], starts: Collection[str], by_name: bool = True
) -> list[tuple[int, Curve]]:
    """Lines that hide one another as the first, which has the name of all, if there is one.

    Those of all `starts` at one place have one, that of each or, not `by_name`, of all of them.
    Where several places have one line, the starts of each place may.
    """
    (place, first), told = group[0], tuple(one.label for _, one in group)
    names = tuple(chain(*(one.names or (one.label,) for _, one in group)))
    if len(group) == 1 or len({(*one.words,) for _, one in group}) > 1:
        return group
    own = {one.words.get("initial") for _, one in group}
    is_one = len({one.without("initial") for _, one in group}) == 1 and len(group) == len(own)
    of_each = is_one and own == starts and not any(one.is_random for _, one in group)
    if of_each and not (by_name and points.of_all(told)):
        words = {**first.words, "initial": points.SHARED[len(starts) > 2]}
        return [(place, replace(first, words=words, names=names))]
    if not points.of_all(told):
        places: dict[str, list[tuple[int, Curve]]] = {}
        for at, one in group:
            places.setdefault(one.without("initial"), []).append((at, one))
        apart = [*places.values()] if len(places) > 1 else [[one] for one in group]
        return [*chain(*(_as_one(one, starts, by_name) for one in apart))]
    words = {
        dim: points.BOTH.join(dict.fromkeys(one.words[dim] for _, one in group))
        for dim in first.words
    }
    return [(place, replace(first, words=words, names=names))]
