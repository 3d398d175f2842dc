"""Where a loop over orders keeps the coefficients of a Taylor step.

Row k of the array ``v`` holds what later orders need of order k: of each sum of products the left
factor, the right factor and the sum itself, in three stretches of one `width`, then what is needed
as it is. So the products of a sum, of which a disc has dozens, are added for several sums at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """The columns of such a table, by nodes.

    Attributes
    ----------
    products : nodes whose coefficients are sums of products
    kept : nodes whose lower coefficients are needed as they are
    """

    products: Sequence[int]
    kept: Sequence[int]

    @property
    def width(self) -> int:
        """Numbers in a stretch."""
        return len(self.products)

    @property
    def stride(self) -> int:
        """Numbers in a row."""
        return 3 * self.width + len(self.kept)

    def factor(self, side: int, node: int) -> int:
        """Column of the left (0) or right (1) factor of a product, or (2) of their sum."""
        return side * self.width + self.products.index(node)

    def own(self, node: int) -> int:
        """Column of a node that is kept as it is."""
        return 3 * self.width + self.kept.index(node)

    def at(self, order: int, column: int) -> str:
        """An entry of the row of an order, as text."""
        return f"v[{order * self.stride + column}]"

    def back(self, orders: int, column: int) -> str:
        """An entry so many rows above that of order k, as text."""
        return f"v[{self.stride} * k {signed(column - orders * self.stride)}]"


def signed(number: int) -> str:
    """Text of ``+ number``."""
    return f"{'-' if number < 0 else '+'} {abs(number)}"
