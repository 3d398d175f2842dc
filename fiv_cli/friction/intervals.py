"""Pieces that are the intervals of a quantity, one after the other: a table, a regularised sign.

The last four numbers of a row are of the two guards, upper border - x and x - lower border, where
there is such a border.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Exit, Piece

if TYPE_CHECKING:
    from sympy import Expr

NO_BORDER = 1.0, 0.0


def intervals(
    borders: Sequence[float], names: Sequence[str], rows: Sequence[tuple[float, ...]]
) -> tuple[Piece, ...]:
    """The pieces between `borders`, which rise; one more of names and rows than of borders."""
    uppers = [*((border, -1.0) for border in borders), NO_BORDER]
    lowers = [NO_BORDER, *((-border, 1.0) for border in borders)]
    above = [*(Exit(name, (0, 1)) for name in names[1:]), None]
    below = [None, *(Exit(name, (1, 0)) for name in names[:-1])]
    return tuple(
        Piece(name, (*row, *upper, *lower), exits)
        for name, row, upper, lower, exits in zip(
            names, rows, uppers, lowers, zip(above, below, strict=True), strict=True
        )
    )


def guards(x: Expr, row: Sequence[Expr]) -> tuple[Expr, Expr]:
    """The guards of the piece with these numbers."""
    upper, falling, lower, rising = row[-4:]
    return upper + falling * x, lower + rising * x


def piece_at(x: float, borders: Sequence[float], pieces: Sequence[Piece]) -> Piece:
    """The piece that x lies in; on a border the one above it."""
    return pieces[bisect(borders, x)]
