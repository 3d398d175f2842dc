"""Which event enters or leaves a cycle where its branch grazes, and of which contact."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from fiv_cli.analyses.cycles.branch import GRAZING, Continuation, End, Point, motions_beyond
from fiv_cli.analyses.cycles.periodic import Event
from fiv_cli.dynamics.motion import Stop
from fiv_cli.flags import CONTACT_STATE, NOT_COMPUTED

SLIP_REVERSAL, LAW_PIECE, ORDER = "slip_reversal", "law_piece", "order"
SEVERAL = 0  # contacts, which are numbered from 1


def grazed(line: Continuation, end: End) -> tuple[str, int]:
    """The event, and the number of its contact; no event where it is none that is known.

    Where two events change places there is none that enters or leaves.
    """
    if end.kind != GRAZING or end.last is None:
        return NOT_COMPUTED, SEVERAL
    differ = _difference(line, end, end.last)
    contacts = {contact for _, _, contact in differ}
    if not differ and end.beyond and end.beyond.cycle.signature != end.last.cycle.signature:
        return ORDER, SEVERAL
    return _named(differ), contacts.pop() + 1 if len(contacts) == 1 else SEVERAL


def _difference(line: Continuation, end: End, last: Point) -> list[Event]:
    """Events of the cycles to one side alone; at the end of a branch those of motions beyond."""
    here = last.cycle.around.events
    others = _beyond(line, last) if end.beyond is None else [end.beyond.cycle.around.events]
    counts = (Counter(here), Counter(next((one for one in others if one != here), here)))
    return [*(counts[0] - counts[1]), *(counts[1] - counts[0])]


def _beyond(line: Continuation, last: Point) -> Iterator[tuple[Event, ...]]:
    """Events of motions beyond the last cycle that last as long as it does."""
    yield from (one.events for one in motions_beyond(line, last) if one.stop == Stop.REACHED)


def _named(events: Sequence[Event]) -> str:
    """What a contact does in them that it does not on the other side."""
    states = {state for before, after, _ in events for state in (before, after)}
    told = (name for name in ("separation", "stick") if CONTACT_STATE.codes[name] in states)
    slips = states <= {*CONTACT_STATE.codes.values()}
    further = SLIP_REVERSAL if slips else LAW_PIECE
    return next(told, further) if states else NOT_COMPUTED
