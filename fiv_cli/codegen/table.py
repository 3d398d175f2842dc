"""Where a loop over orders keeps the coefficients of a Taylor step.

Row k of the array ``v`` holds what later orders need of order k: of each sum of products the left
factor, the right factor and the sum itself, in three stretches of one `width`, then what is needed
as it is. So the products of a sum, of which a disc has dozens, are added for several sums at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from fiv_cli.codegen.graph import Node


class Factors(NamedTuple):
    """What is multiplied in a sum of products.

    Attributes
    ----------
    left, right : the coefficients of order k are sums over j of left_j right_{k-j}
    by_order : times j: what is summed is the product of a rate
    """

    left: Node
    right: Node
    by_order: bool = False


@dataclass(frozen=True)
class Table:
    """The columns of such a table.

    Attributes
    ----------
    factors : index of a node whose coefficients are sums of products -> its factors
    kept : index -> node whose lower coefficients are needed as they are
    """

    factors: Mapping[int, Factors]
    kept: Mapping[int, Node]

    @property
    def width(self) -> int:
        """Numbers in a stretch."""
        return len(self.factors)

    @property
    def stride(self) -> int:
        """Numbers in a row."""
        return 3 * self.width + len(self.kept)

    def factor(self, side: int, index: int) -> int:
        """Column of the left (0) or right (1) factor of a node, or (2) of their sum."""
        return side * self.width + list(self.factors).index(index)

    def own(self, index: int) -> int:
        """Column of a node that is kept as it is."""
        return 3 * self.width + list(self.kept).index(index)

    def at(self, order: int, column: int) -> str:
        """An entry of the row of an order, as text."""
        return f"v[{order * self.stride + column}]"

    def back(self, orders: int, column: int) -> str:
        """An entry so many rows above that of order k, as text."""
        offset = column - orders * self.stride
        return f"v[{self.stride} * k {'-' if offset < 0 else '+'} {abs(offset)}]"
