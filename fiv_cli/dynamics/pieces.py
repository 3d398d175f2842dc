"""The pieces of the laws of a system, numbered over all of these, as the driver reads them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fiv_cli.codegen.memory import Array
from fiv_cli.friction.base import Exit, Law, Piece, room_of_pieces


@dataclass(frozen=True, eq=False)
class Pieces:
    """The laws that are given by pieces, of each contact that has one.

    Contacts of one law share its pieces. Rows are filled up with zeros to one width, and pieces
    with ways out that nothing takes to one number of these.
    """

    laws: Mapping[int, Law]

    @cached_property
    def room(self) -> tuple[int, int]:
        """Numbers of a piece, and ways out of one."""
        return room_of_pieces(self.laws.values())

    @cached_property
    def firsts(self) -> dict[Law, int]:
        """Each law, and the number of its first piece."""
        found: dict[Law, int] = {}
        for law in self.laws.values():
            found.setdefault(law, sum(len(other.pieces) for other in found))
        return found

    @cached_property
    def begun_in(self) -> list[int]:
        """The piece that each element of every contact begins in."""
        return [self.firsts[law] for law in self.laws.values() for _ in range(law.elements)]

    @cached_property
    def first_rows(self) -> list[float]:
        """The numbers of these."""
        every = [law.pieces[0] for law in self.laws.values() for _ in range(law.elements)]
        return self.numbers([piece.row for piece in every])

    @property
    def events(self) -> list[str]:
        """Words for the pieces in a ledger."""
        return [word for law in self.firsts for word in law.events]

    def numbers(self, rows: Sequence[Sequence[float]]) -> list[float]:
        """Rows of numbers of pieces as they stand in the parameter vector."""
        width, _ = self.room
        return [x for row in rows for x in (*row, *(0.0,) * (width - len(row)))]

    def tables(self, states: Sequence[str]) -> dict[str, Array]:
        """What the driver reads; `states` are the entries of the state vector."""
        width, ways = self.room
        every = [(law, piece) for law in self.firsts for piece in law.pieces]
        exits = [(law, one) for law, piece in every for one in self._ways_out(piece)]
        leading = [
            -1 if one is None else self.firsts[law] + law.places[one.to] for law, one in exits
        ]
        zeros = [() if one is None else one.zeros for _, one in exits]
        count = max(len(every), 1)
        anew = [one is not None and one.begins_anew for _, one in exits]
        return {
            "element_states": np.array(self._states(states), np.int64),
            "element_contacts": np.array(self._contacts, np.int64),
            "piece_rows": np.array(self.numbers([p.row for _, p in every])).reshape(count, width),
            "piece_exits": np.array(leading, np.int64).reshape(count, ways),
            "piece_begins": np.array(anew, np.int64).reshape(count, ways),
            "piece_zeros": np.array(
                [(*known, *(0,) * (ways - len(known))) for known in zeros], np.int64, ndmin=2
            ),
        }

    def _ways_out(self, piece: Piece) -> tuple[Exit | None, ...]:
        _, ways = self.room
        return (*piece.exits, *(None,) * (ways - len(piece.exits)))

    @property
    def _contacts(self) -> list[int]:
        return [contact for contact, law in self.laws.items() for _ in range(law.elements)]

    def _states(self, names: Sequence[str]) -> list[int]:
        """Entry of the state vector of the first internal state of each element."""
        found = []
        for contact, law in self.laws.items():
            own = len(law.states) // law.elements
            heads = [state.name for state in law.states[::own]] if own else []
            known = [
                next(n for n in (head, f"{head}_{contact + 1}") if n in names) for head in heads
            ]
            found += [names.index(name) for name in known] or [0] * law.elements
        return found
