"""Phase portrait: one state against another, coloured by the state of the contact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, cycle, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from fiv_cli.plots import legends, motion, points, smooth, style
from fiv_cli.reading import sampling

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

suits = motion.suits
WIDE = 0.3  # share of the extent of a curve on which a head is seen to lie along it
OTHER_STICKS = ("#777777", "#A6A6A6", style.YELLOW, style.SKY)  # contact by contact

HEAD: dict[str, Any] = {
    # twice as long as wide: of three equal sides none would tell which way it points
    "arrowstyle": "-|>,head_length=0.8,head_width=0.2", "mutation_scale": 10.0,
    "color": style.BLACK, "lw": 0.0, "shrinkA": 0.0, "shrinkB": 0.0,
}  # fmt: skip
# A head's length, and how far along a curve a place for it is looked for, as shares of its extent.
ROOM, TURN, PLACES = 0.06, 4.0, 300
# Of the extent: a start as near as that would be hidden, and a piece as short, of the last so many.
CLEAR, SHORT, MOST_PIECES = 0.1, 0.12, 20
MARKERS = "osD^vphX"
MARK: dict[str, Any] = {"ms": 5, "mfc": "none", "color": style.BLACK, "ls": "none"}
# A path retraces itself where, having been AWAY, it comes BACK to its start, in shares of its
# extent, and so does this share of its instants, of so many.
AWAY, BACK = 0.1, 1e-3
MOST, INSTANTS = 0.998, 20_000
# What jumps at an event, by more than this share of its extent, is neither before nor after it; of
# what reaches no farther no line would be seen: it is a dot.
JUMP: dict[str, Any] = {"color": "#444444", "ls": ":", "lw": 1.0}  # over a stick along it
SEEN, DOT = 0.01, 4.0
OF_CONTACTS = (
    "motions stick on several contacts, whose marks lie upon one another where they meet; a figure "
    "of each motion alone, or `select` of one contact, tells them apart"
)
HELD: dict[str, Any] = {"color": style.BLACK, "ls": "--", "lw": 1.0}


def draw(layers: Sequence[points.Layer], settings: points.Settings) -> Figure:
    """A panel for each motion, or one for all (``overlay``, and those of several datasets); a mark
    stands at each start.

    It names a motion among a few in one panel, of settled ones at some point of each.
    """
    datasets = [layer.dataset for layer in layers]
    dataset, shared = datasets[0], bool(settings.get("overlay")) or len(layers) > 1
    motions = motion.of_files(layers, {**settings, "overlay": shared})
    settings = motion.about_one_that_sticks(motions, settings)
    names, *_ = [_states(one, settings) for one in datasets]  # which all must have
    marks = _marks(motions, shared, settings)
    figure, axes = style.new_panels(1, 1 if shared else len(motions), points.title(*datasets))
    portraits = [_portrait(*of, names, settings) for of in zip(motions, marks, strict=True)]
    for number, portrait in enumerate(portraits):
        _panel(axes[0 if shared else number], portrait, names, settings)
    if shared and len(motions) > 1 and any(portrait.sticks for portrait in portraits):
        style.add_notes(figure, [OF_CONTACTS])
    for ax, one in zip(axes, motions, strict=False):
        ax.set_title("" if shared else one.label)
        ax.set_xlabel(motion.label_of(dataset[names[0]], settings))
    axes[0].set_ylabel(motion.label_of(dataset[names[1]], settings))
    legends.legend_below(
        figure, [*_keys(portraits, names)], motion.named_contact(dataset, settings)
    )
    return figure


def _keys(portraits: Sequence[_Portrait], names: tuple[str, str]) -> Iterator[Line2D]:
    """The entries of a legend, of what is drawn alone."""
    motions, marks = [one.motion for one in portraits], [one.mark for one in portraits]
    for state, words in motion.CONTACT_STATES.items():
        yield from _key(words, [one.states.get(state) for one in portraits])
    for number in sorted({*chain.from_iterable(one.sticks for one in portraits)}):
        yield from _key(motion.sticking(number), [one.sticks.get(number) for one in portraits])
    if any(one.jumps for one in portraits):
        yield Line2D([], [], label="jump", **JUMP)
    yield from motion.ends(motions)
    yield from motion.sampled(motions, names)
    if any(np.isfinite(_held(one, names)) for one in motions):
        yield Line2D([], [], label="held in stick", **HELD)
    is_coarse = all(one.path.is_coarse for one in portraits)
    of_lines = len({mark.dash for mark in marks}) > 1 and not is_coarse
    named = {mark.label: mark.key(with_line=of_lines) for mark in marks if mark.label}
    yield from named.values()


@dataclass(frozen=True)
class _Mark:
    """What stands at the first sample of a motion, or where it rests; "" is unmarked."""

    label: str
    marker: str
    dash: Any = "-"  # of its motion

    def key(self, *, with_line: bool) -> Line2D:
        """Its entry of a legend."""
        look = {**MARK, "ls": self.dash, "color": style.BLACK} if with_line else MARK
        return Line2D([], [], label=self.label, marker=self.marker, **look)


def _marks(
    motions: Sequence[motion.Motion], shared: bool, settings: points.Settings
) -> list[_Mark]:
    """Marks of starts; of a few motions in one panel each has its own, which names it."""
    words = [_of_first_sample(one.data, settings) for one in motions]
    if not shared or not 1 < len(motions) <= len(MARKERS):
        return [_Mark(word, MARKERS[word == "at rest"]) for word in words]
    whats = [word or motion.what_it_is(one.data) for word, one in zip(words, motions, strict=True)]
    alone = [what.endswith("cycle") and whats.count(what) == 1 for what in whats]
    told = [
        one.data.attrs.get("called") or what if is_alone else f"{what}: {one.label}"
        for what, one, is_alone in zip(whats, motions, alone, strict=True)
    ]
    return [_Mark(word, mark, ls) for word, mark, ls in zip(told, MARKERS, cycle(style.DASHES))]


def _of_first_sample(data: xr.Dataset, settings: points.Settings) -> str:
    """What it is; a window of time may begin anywhere, a settled motion too: that is no start."""
    if sampling.is_at_rest(data):
        return "at rest"
    return "" if "window" in settings or points.is_settled(data) else "start"


def _states(dataset: xr.Dataset, settings: points.Settings) -> tuple[str, str]:
    """x and y: as the figure says, else the first displacement and its velocity.

    Of a law under a stated slip it is the loop: the slip and the force.
    """
    x = str(settings.get("x", motion.variables(dataset, settings)[0]))
    y = str(settings.get("y", "F_T" if "static_capacity" in dataset else f"{x}_dot"))
    return motion.known_variable(dataset, x), motion.known_variable(dataset, y)


@dataclass(frozen=True)
class _Path:
    """A motion in the plane of two states: through samples and events, or, coarse, the samples."""

    time: np.ndarray
    points: np.ndarray
    is_coarse: bool
    is_long: bool

    def once_around(self) -> float:
        """The instant from which on it retraces itself, so that dashes would fill their gaps."""
        if self.is_coarse:
            return np.inf
        even = np.linspace(self.time[0], self.time[-1], INSTANTS)
        places = np.column_stack([np.interp(even, self.time, own) for own in self.points.T])
        places /= np.maximum(np.ptp(places, axis=0), np.finfo(float).tiny)
        off = abs(places - places[0]).max(axis=1)
        left = int(np.argmax(off > AWAY))
        near = (off < BACK) & (np.arange(INSTANTS) > left) & (left > 0)
        visits = np.split(np.arange(INSTANTS), np.flatnonzero(np.diff(near)) + 1)
        for visit in (one for one in visits if near[one[0]]):
            lag = int(visit[off[visit].argmin()])
            if np.quantile(abs(places[lag:] - places[:-lag]).max(axis=1), MOST) < BACK:
                return float(even[lag])
        return np.inf

    def between(self, begin: float, end: float) -> list[np.ndarray]:
        """What of it lies between two instants, smooth where it may be, in pieces between jumps."""
        first, last = np.searchsorted(self.time, (begin, end)).tolist()
        if self.is_coarse:
            return [self.points[first:last]]
        first = max(0, int(np.searchsorted(self.time, begin, "right")) - 1)  # after what is there
        cuts = [at for at in np.flatnonzero(self.is_jump) + 1 if first < at <= last]
        bounds = pairwise([first, *cuts, last + 1])
        return [_smooth(self.time[a:b], self.points[a:b]) for a, b in bounds if a < b]

    @cached_property
    def is_jump(self) -> np.ndarray:
        """Which of its steps from point to point take no time and go far."""
        far = abs(np.diff(self.points, axis=0)) > SEEN * np.ptp(self.points, axis=0)
        return ~np.bool_(self.is_coarse) & (np.diff(self.time) <= 0.0) & far.any(axis=1)

    def jumps(self, until: float) -> list[np.ndarray]:
        """What is before and what is after each jump up to an instant, shape (2, 2)."""
        places = np.flatnonzero(self.is_jump & (self.time[:-1] < until))
        return [self.points[place : place + 2] for place in places]

    def is_seen(self, pieces: Sequence[np.ndarray]) -> bool:
        """Whether lines of some pieces are."""
        extent = SEEN * np.ptp(self.points, axis=0)
        return any((np.ptp(piece, axis=0) > extent).any() for piece in pieces if piece.size)

    def draw(self, ax: Axes, pieces: Sequence[np.ndarray], label: str, **look: Any) -> None:
        """Pieces of one colour."""
        marks: dict[str, Any] = {"ls": "none", "marker": ".", "color": look["color"]}
        marks |= {"rasterized": self.is_long, "label": label, "zorder": look.get("zorder")}
        if self.is_coarse:
            ax.plot(*np.concatenate(pieces).T, ms=2.0 * look["lw"], **marks)
        elif not self.is_seen(pieces):
            places = [piece.mean(axis=0) for piece in pieces]
            ax.plot(*np.transpose(places), ms=DOT + look["lw"], **marks)
        else:
            ax.add_collection(LineCollection(pieces, label=label, rasterized=self.is_long, **look))


def path_of(one: motion.Motion, names: tuple[str, str], settings: points.Settings) -> _Path:
    """A motion in the plane of two variables."""
    values = [motion.of_contact(one.data[name], settings) for name in names]
    is_long = one.time.size > style.MANY_MARKS
    if one.is_coarse(*names):
        return _Path(one.time, np.column_stack(values), True, is_long)
    drawn = [one.drawn(*named) for named in zip(names, values, strict=True)]
    return _Path(one.drawn_time, np.column_stack(drawn), False, is_long)


@dataclass(frozen=True)
class _Part:
    """What of a motion is drawn in one look."""

    path: _Path
    pieces: list[np.ndarray]
    look: dict[str, Any]


@dataclass(frozen=True)
class _Portrait:
    """What is drawn of one motion: parts for each state of a contact, and for sticks of others.

    It has none where the motion rests.
    """

    motion: motion.Motion
    path: _Path
    mark: _Mark
    states: dict[str, _Part]
    sticks: dict[int, _Part]
    jumps: list[np.ndarray]


def _portrait(
    one: motion.Motion, mark: _Mark, names: tuple[str, str], settings: points.Settings
) -> _Portrait:
    path = path_of(one, names, settings)
    if sampling.is_at_rest(one.data):
        return _Portrait(one, path, mark, {}, {}, [])
    until = path.once_around() if mark.dash != "-" else np.inf
    spans = [span for span in motion.contact_spans(one, settings) if span[1] < until]
    states: dict[str, _Part] = {}
    for state, begin, end in spans:
        look = {"color": style.CLASSES[state], "lw": 1.0, "ls": mark.dash}
        part = states.setdefault(state, _Part(path, [], look))
        part.pieces.extend(path.between(begin, min(end, until)))
    sticks: dict[int, _Part] = {}
    for contact, *span in _bands(one, settings):
        part = sticks.setdefault(contact, _Part(path, [], _band(contact)))
        part.pieces.extend(path.between(*span))
    is_held = bool(np.isfinite(_held(one, names)))  # which stands where its force jumps
    return _Portrait(one, path, mark, states, sticks, [] if is_held else path.jumps(until))


def _key(label: str, parts: Sequence[_Part | None]) -> Iterator[Line2D]:
    """The entry of a legend of what has parts of motions, if it has any."""
    there = [part for part in parts if part]
    fine = [part for part in there if not part.path.is_coarse]
    for first in there[:1]:
        look = {key: first.look[key] for key in ("color", "lw")}
        if not any(part.path.is_seen(part.pieces) for part in fine):
            look |= {"ls": "none", "marker": "." if fine else "o"}
        yield Line2D([], [], label=label, **look)


def _panel(
    ax: Axes, portrait: _Portrait, names: tuple[str, str], settings: points.Settings
) -> None:
    one, path, mark = portrait.motion, portrait.path, portrait.mark
    if not portrait.states:
        _rest(ax, one, names, mark)
        return
    for state, part in portrait.states.items():
        path.draw(ax, part.pieces, points.joined(one.label, state), **part.look)
    if portrait.jumps:
        path.draw(ax, portrait.jumps, points.unlisted(one.label, "jump"), zorder=2.1, **JUMP)
    if not path.is_coarse:
        parts = [*portrait.states.values(), *portrait.sticks.values()]
        pieces = [piece for part in parts for piece in part.pieces]
        _point_onwards(ax, path, pieces)
    for contact, part in portrait.sticks.items():
        stick = points.unlisted(one.label, motion.sticking(contact))
        path.draw(ax, part.pieces, stick, **part.look)
    if mark.label:
        label = points.unlisted(one.label, mark.label)
        ax.plot(*path.points[0], marker=mark.marker, label=label, **MARK)
    if one.end:
        ax.plot(*path.points[-1], label=points.unlisted(one.label, one.end), **motion.END)
    held = _held(one, names)
    if np.isfinite(held):
        stick = points.unlisted(one.label, "held in stick")
        ax.plot([0.0, 0.0], [-held, held], label=stick, **HELD)
    ax.autoscale_view()
    points.scale(ax, settings)


def _bands(one: motion.Motion, settings: points.Settings) -> Iterator[tuple[int, float, float]]:
    """(contact, begin, end in s) of each stick of a contact that the colours are not about."""
    return motion.other_sticks(one, motion.of_all_contacts(one.data, settings))


def _band(contact: int) -> dict[str, Any]:
    """What shows that it sticks, under the line."""
    return {"color": OTHER_STICKS[(contact - 1) % len(OTHER_STICKS)], "lw": 4.0, "zorder": 1.8}


def _rest(ax: Axes, one: motion.Motion, names: tuple[str, str], mark: _Mark) -> None:
    """One mark, at no velocity: what is left of it is rounding."""
    place = [0.0 if name.endswith("_dot") else one.data[name].values[0] for name in names]
    ax.plot(*place, marker=mark.marker, label=points.unlisted(one.label, mark.label), **MARK)


def _point_onwards(ax: Axes, of: _Path, pieces: Sequence[np.ndarray]) -> None:
    """An arrowhead in the direction of the motion, on the straightest stretch of its curve off its
    start, off jumps, and off such pieces of it as it would hide: where its second half, which is
    nearer to a closed one, is wide enough, there."""
    path, extent = of.points, np.ptp(of.points, axis=0)
    halves = path[len(path) // 2 :], path
    late = next(half for half in halves if (np.ptp(half, axis=0) >= WIDE * extent).all())
    scaled = late / np.where(extent > 0.0, extent, 1.0)
    is_jump = of.is_jump[len(path) - len(late) :]
    steps = np.where(is_jump, 0.0, np.linalg.norm(np.diff(scaled, axis=0), axis=1))
    along = np.append(0.0, np.cumsum(steps))
    places = np.linspace(0.0, min(along[-1], TURN), PLACES)
    even = np.column_stack([np.interp(places, along, scaled[:, axis]) for axis in (0, 1)])
    reach = min(1 + int(ROOM * PLACES / max(places[-1], ROOM)), PLACES // 3 - 1)
    chords = np.linalg.norm(even[3 * reach :] - even[: -3 * reach], axis=1)
    small = [piece for piece in pieces if (np.ptp(piece, axis=0) < SHORT * extent).all()]
    hidden = np.concatenate([path[:1], *small[-MOST_PIECES:]]) / np.where(extent > 0.0, extent, 1.0)
    middle = 0.5 * (even[3 * reach :] + even[: -3 * reach])
    off = np.linalg.norm(middle[:, None] - hidden, axis=-1).min(axis=1)
    chords[off < CLEAR] *= 0.5
    leaps = along[1:][is_jump]
    over = (places[: -3 * reach, None] < leaps) & (leaps < places[3 * reach :, None])
    chords[over.any(axis=1)] *= 0.1
    if along[-1] > 0.0:
        tail, tip = (even[int(chords.argmax()) + n * reach] * extent for n in (1, 2))
        ax.annotate("", tip, tail, arrowprops=HEAD)


def _held(one: motion.Motion, names: tuple[str, str]) -> float:
    """The greatest force that a law holds in stick, which stands upright in its loop, else NaN."""
    is_loop = names == ("slip_dot", "F_T") and "static_capacity" in one.data
    return float(one.data["static_capacity"]) if is_loop else np.nan


def _smooth(time: np.ndarray, path: np.ndarray) -> np.ndarray:
    """The path through its samples, smooth and without overshoot between any two events."""
    corners = np.flatnonzero(np.diff(time) <= 0.0) + 1
    pieces = zip(np.split(time, corners), np.split(path, corners), strict=True)
    return np.concatenate([smooth.through(*piece) for piece in pieces])
