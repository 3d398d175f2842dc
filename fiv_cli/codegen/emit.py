"""Straight-line text from the expression graph.

Two kinds of function come out, both with the signature ``(c, t, y, out)``: pointwise ones, and
Taylor steps, which write the series of the state vector and of the switching functions about (t,
y). Those of tangent vectors have the signature ``(c, t, y, lanes)``: each operation is done for as
many vectors as an entry of ``lanes`` holds, and likewise for the times that ``nodes`` holds. A
series that is structurally a polynomial (time; a displacement in stick) stops at its degree.

A step with many sums of products (a disc's) goes through the higher orders in a loop: its text and
machine code are a tenth as long, short enough to stay where the processor fetches code fastest, and
``convolve(v, k, width, stride)`` sums the products of order k of all of them, see `table.py`.

The text is Python that can be read and run, and nothing but assignments, + - * /, the functions of
`graph.UNARY`, `pow` and `rint`, that loop and that call: `lower.py` turns exactly that into machine
code.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from math import comb, factorial, pi

from fiv_cli.codegen.graph import Graph, Node, reachable
from fiv_cli.codegen.table import Factors, Table

UNBOUNDED = 10**6  # degree of a series that does not end
# What a value waits for: coefficients, sums, and what takes as long as several of them.
WAITED_FOR = re.compile(r"[^\W\d]\w*_(?:\d+|k)\b|[-+]|/|\w\(")
WAITS = {"+": 1, "-": 1, "/": 3}
CALL = 10
MANY = 8  # sums of products from which on orders are gone through in a loop
# Functions whose recurrence needs the series of another one of the same argument.
PARTNER: dict[str, Callable[[Graph, Node], Node]] = {
    "sin": lambda graph, argument: graph.unary("cos", argument),
    "cos": lambda graph, argument: graph.unary("sin", argument),
    "asin": lambda graph, argument: graph.cosine_of_asin(argument),
}
# Quarters of a turn that a sine is ahead by; what a quarter is beyond its double; terms of sine and
# cosine over an eighth, from the third and the fourth power on, to rounding.
TURNS = {"sin": 0.0, "cos": 1.0}
BEYOND_QUARTER = 6.123233995736766e-17
SINE = [(-1.0) ** k / factorial(2 * k + 1) for k in range(1, 9)]
COSINE = [(-1.0) ** k / factorial(2 * k) for k in range(2, 9)]


class Coefficients:
    """Constant nodes that the code needs, each in one slot of the array ``c``."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._slots: dict[int, int] = {}

    def text(self, node: Node) -> str:
        """A literal, or the slot of `node`."""
        if node.op == "number":
            return repr(node.value)
        slot = self._slots.get(node.index)
        if slot is None:
            slot = self._slots[node.index] = len(self.nodes)
            self.nodes.append(node)
        return f"c[{slot}]"


def pointwise(
    graph: Graph, name: str, comment: str, outputs: Sequence[Node], coefficients: Coefficients
) -> list[str]:
    """Text of a function that writes `outputs` at (t, y)."""
    lines = [f"def {name}(c, t, y, out):", f"    # {comment}"]
    names: dict[int, str] = {}
    for node in reachable(outputs):
        names[node.index] = graph.name(node)
        lines.append(f"    {graph.name(node)} = {_value(node, names, coefficients)}")
    return lines + _output_lines("out", outputs, names, coefficients)


def along_series(
    graph: Graph,
    name: str,
    comment: str,
    outputs: Sequence[Node],
    order: int,
    coefficients: Coefficients,
    target: str = "lanes",
) -> list[str]:
    """Text of a function that writes `outputs` at times into a step that begins at ``t``.

    ``y`` are the series of the state there, the first of `target` the times. In ``nodes`` sines and
    cosines are sums, which cost all times together what a call costs one.
    """
    lines = [f"def {name}(c, t, y, {target}):", f"    # {comment}", f"    x = {target}[0]"]
    lines.append("    square = x * x")
    names: dict[int, str] = {}
    turned: set[int] = set()
    for node in reachable(outputs):
        names[node.index] = own = f"{graph.name(node)}_0"  # a state may be called x
        if node.op == "state":
            lines += _sum_lines(own, "y", node.value * (order + 1), order, "x")
        elif target == "nodes" and node.op in TURNS:
            (argument,) = node.args
            if argument.index not in turned:
                lines += _turn_lines(names[argument.index])
                turned.add(argument.index)
            lines += _wave_lines(own, names[argument.index], TURNS[node.op])
        else:
            text = "t + x" if node.op == "time" else _value(node, names, coefficients)
            lines.append(f"    {own} = {text}")
    return lines + _output_lines(target, outputs, names, coefficients)


def _turn_lines(angle: str) -> list[str]:
    """Nearest quarter of a turn, and sine and cosine of what is left of an angle then."""
    quarters, left, square = f"{angle}_q", f"{angle}_r", f"{angle}_s"
    return [
        f"    {quarters} = rint({2.0 / pi!r} * {angle})",
        f"    {left} = {angle} - {pi / 2.0!r} * {quarters} - {BEYOND_QUARTER!r} * {quarters}",
        f"    {square} = {left} * {left}",
        f"    {angle}_sin = {left} + {left} * {square} * {_nested(SINE, square)}",
        f"    {angle}_cos = 1.0 - 0.5 * {square} + {square} * {square} * {_nested(COSINE, square)}",
    ]


def _wave_lines(name: str, angle: str, ahead: float) -> list[str]:
    """Sine of an angle so many quarters of a turn ahead of what `_turn_lines` knows."""
    return [
        f"    {name}_q = {angle}_q + {ahead!r}",
        f"    {name}_m = {name}_q - 4.0 * rint(0.25 * {name}_q - 0.375)",
        f"    {name}_h = rint(0.5 * {name}_m - 0.25)",
        f"    {name}_o = {name}_m - 2.0 * {name}_h",
        f"    {name}_w = {angle}_sin + {name}_o * ({angle}_cos - {angle}_sin)",
        f"    {name} = {name}_w - 2.0 * {name}_h * {name}_w",
    ]


def _nested(terms: Sequence[float], variable: str) -> str:
    """A polynomial in parentheses, lowest term first."""
    first, *rest = terms
    return f"({first!r} + {variable} * {_nested(rest, variable)})" if rest else repr(first)


def _output_lines(
    array: str, outputs: Sequence[Node], names: dict[int, str], coefficients: Coefficients
) -> list[str]:
    texts = [coefficients.text(node) if node.constant else names[node.index] for node in outputs]
    return [f"    {array}[{row}] = {text}" for row, text in enumerate(texts)]


def sums(name: str, count: int, order: int) -> list[str]:
    """Text of the function that sums the first `count` series (its ``y``) at the time ``t``."""
    lines = [f"def {name}(c, t, y, out):", "    # value of each entry of the state"]
    lines.append("    square = t * t")
    for row in range(count):
        lines += _sum_lines(f"out[{row}]", "y", row * (order + 1), order, "t")
    return lines


def sums_in_place(name: str, count: int, order: int) -> list[str]:
    """The same of series of tangent vectors: each sum takes the place of the value at 0."""
    lines = [f"def {name}(c, t, y, lanes):", "    # value of each entry of tangent vectors"]
    lines.append("    square = t * t")
    for first in range(0, count * (order + 1), order + 1):
        lines += _sum_lines(f"lanes[{first}]", "lanes", first, order, "t")
    return lines


def _sum_lines(target: str, array: str, first: int, order: int, time: str) -> list[str]:
    """Sum of the series that begins at `first`, at a time whose square is at hand.

    Even and odd powers are summed apart: two short chains of operations instead of a long one.
    """
    lines = []
    for name, top in (("even", order - order % 2), ("odd", order - 1 + order % 2)):
        lines.append(f"    {name} = {array}[{first + top}]")
        for k in range(top - 2, -1, -2):
            lines.append(f"    {name} = {name} * square + {array}[{first + k}]")
    return [*lines, f"    {target} = even + {time} * odd"]


def value_slope_bend(name: str, degree: int) -> list[str]:
    """Text of the function that evaluates a polynomial (its ``y``) and two derivatives at ``t``.

    Even and odd powers are summed apart, as in `sums`.
    """
    lines = [f"def {name}(c, t, y, out):", "    # value and derivatives of a polynomial"]
    lines += ["    square = t * t"]
    for part, top, last in (
        ("even", degree - degree % 2, 0),
        ("odd", degree - 1 + degree % 2, 1),
    ):
        lines += [f"    {part} = y[{top}]", f"    {part}_slope = 0.0", f"    {part}_bend = 0.0"]
        for k in range(top - 2, last - 1, -2):
            lines.append(f"    {part}_bend = {part}_bend * square + {part}_slope")
            lines.append(f"    {part}_slope = {part}_slope * square + {part}")
            lines.append(f"    {part} = {part} * square + y[{k}]")
    return [
        *lines,
        "    slope = even_slope + t * odd_slope",
        "    bend = even_bend + t * odd_bend",
        "    out[0] = even + t * odd",
        "    out[1] = odd + 2.0 * t * slope",
        "    out[2] = 2.0 * slope + 4.0 * t * odd_slope + 8.0 * square * bend",
    ]


def bernstein(name: str, degree: int) -> list[str]:
    """Text of the function that turns a polynomial's coefficients (its ``y``) into Bernstein's.

    On [0, 1] coefficient j is the sum of C(j, i) y_i / C(degree, i): the sums of Pascal's triangle,
    row after row.
    """
    lines = [f"def {name}(c, t, y, out):", f"    # Bernstein coefficients, degree {degree}"]
    lines += [f"    b{i} = y[{i}] * {1.0 / comb(degree, i)!r}" for i in range(degree + 1)]
    for row in range(1, degree + 1):
        lines += [f"    b{j} = b{j} + b{j - 1}" for j in range(degree, row - 1, -1)]
    return lines + [f"    out[{j}] = b{j}" for j in range(degree + 1)]


def constants(name: str, nodes: Sequence[Node], parameters: Sequence[str]) -> list[str]:
    """Text of the function that fills ``c`` (its ``out``) from the parameters (its ``y``)."""
    lines = [f"def {name}(c, t, y, out):", "    # what depends on parameters alone"]
    done: dict[int, str] = {}
    for node in nodes:
        _constant_lines(node, parameters, done, lines)
    lines += [f"    out[{slot}] = {done[node.index]}" for slot, node in enumerate(nodes)]
    return lines


def _constant_lines(
    node: Node, parameters: Sequence[str], done: dict[int, str], lines: list[str]
) -> None:
    if node.index in done:
        return
    if node.op == "number":
        done[node.index] = repr(node.value)
        return
    for arg in node.args:
        _constant_lines(arg, parameters, done, lines)
    inner = [done[arg.index] for arg in node.args]
    if node.op == "parameter":
        text = f"y[{list(parameters).index(node.value)}]  # {node.value}"
    elif node.op.endswith("_constant"):
        sign = {"add": "+", "mul": "*", "div": "/"}[node.op.removesuffix("_constant")]
        text = f"{inner[0]} {sign} {inner[1]}"
    elif node.op == "pow":
        text = f"pow({inner[0]}, {node.value!r})"
    else:
        text = f"{node.op}({inner[0]})"
    done[node.index] = f"k{node.index}"
    lines.append(f"    k{node.index} = {text}")


def _value(node: Node, names: dict[int, str], coefficients: Coefficients) -> str:
    """The value of one varying node."""
    if node.op == "time":
        return "t"
    if node.op == "state":
        return f"y[{node.value}]"
    inner = [coefficients.text(a) if a.constant else names[a.index] for a in node.args]
    if node.op == "linear":
        terms = [
            _weighted(weight, text, coefficients)
            for weight, text in zip(node.value[1:], inner, strict=True)
        ]
        return _sum(_constant_term(node, coefficients) + terms)
    if node.op in ("mul", "div"):
        return f"{inner[0]} {'*' if node.op == 'mul' else '/'} {inner[1]}"
    if node.op == "pow":
        return f"pow({inner[0]}, {node.value!r})"
    return f"{node.op}({inner[0]})"


def _constant_term(node: Node, coefficients: Coefficients) -> list[str]:
    text = coefficients.text(node.value[0])
    return [] if text == "0.0" else [text]


def _weighted(weight: Node, text: str, coefficients: Coefficients) -> str:
    factor = coefficients.text(weight)
    if factor == "1.0":
        return text
    if factor == "-1.0":
        return f"-{text}"
    return f"{factor} * {text}"


def _times(factor: float, text: str) -> str:
    """A number times a product."""
    return text if factor == 1.0 else f"{float(factor)!r} * {text}"


def _sum(terms: Sequence[str]) -> str:
    """Terms joined by + and -."""
    if not terms:
        return "0.0"
    text = terms[0]
    for term in terms[1:]:
        text += f" - {term[1:]}" if term.startswith("-") else f" + {term}"
    return text


def _over(k: int) -> str:
    """Division by a whole number, as text after a term."""
    return "" if k == 1 else f" * {1.0 / k!r}"


class TaylorStep:
    """Writes the series of a state vector and of some outputs about (t, y).

    Parameters
    ----------
    graph : where the nodes live
    values, rates : nodes of the state vector and of its derivatives; with a tangent vector,
        its nodes follow those of the state vector
    outputs : further nodes whose series are written after the states'
    order : highest order K
    coefficients : slots of what depends on parameters alone
    """

    def __init__(
        self,
        graph: Graph,
        values: Sequence[Node],
        rates: Sequence[Node],
        outputs: Sequence[Node],
        order: int,
        coefficients: Coefficients,
    ) -> None:
        self.values, self.rates, self.outputs = list(values), list(rates), list(outputs)
        self.order = order
        self.graph, self.name = graph, graph.name
        self.coefficients = coefficients
        self.lines: list[str] = []
        self.known_at: dict[str, int] = {}  # coefficient -> operations that it waits for
        self.nodes = self._needed_for([*self.values, *self.rates, *self.outputs])
        self.size = len(values)
        self.leaves = {
            node.index: position
            for position, node in enumerate(self.values)
            if self._is_own_leaf(node, position)
        }
        self.leaf_names = {
            self.values[p].index: graph.name(self.values[p]) for p in self.leaves.values()
        }
        self.partners = {
            node.index: _partner(graph, node) for node in self.nodes if node.op in PARTNER
        }
        self.degrees = self._degrees()
        self.looped: int | None = None  # the first order of the loop that is being written
        self.table = self._table()

    def _needed_for(self, roots: Sequence[Node]) -> list[Node]:
        """What is computed for `roots`, arguments first."""
        return _with_partners(self.graph, roots)

    def _is_own_leaf(self, node: Node, position: int) -> bool:
        """Whether this entry is integrated, not a function of other entries."""
        if node.op == "tangent":
            return bool(node.value + self.size // 2 == position)
        return node.op == "state" and node.value == position

    # --- structure --------------------------------------------------------------------------------
    def _degrees(self) -> dict[int, int]:
        """Degree of every series that is structurally a polynomial."""
        leaf_degrees = dict.fromkeys(self.leaves, UNBOUNDED)
        while True:
            degrees = self._propagate(leaf_degrees)
            found = {
                leaf: min(UNBOUNDED, self._degree(self.rates[position], degrees) + 1)
                for leaf, position in self.leaves.items()
            }
            found = {leaf: 0 if self._vanishes(leaf) else d for leaf, d in found.items()}
            if found == leaf_degrees:
                return degrees
            leaf_degrees = found

    def _vanishes(self, leaf: int) -> bool:
        rate = self.rates[self.leaves[leaf]]
        return rate.op == "number" and rate.value == 0.0

    def _propagate(self, leaf_degrees: dict[int, int]) -> dict[int, int]:
        degrees: dict[int, int] = {}
        for node in self.nodes:
            degrees[node.index] = self._degree_of(node, degrees, leaf_degrees)
        return degrees

    def _degree_of(self, node: Node, degrees: dict[int, int], leaf_degrees: dict[int, int]) -> int:
        if node.op == "time":
            return 1
        if node.op in ("state", "tangent"):
            return leaf_degrees[node.index]
        inner = [self._degree(arg, degrees) for arg in node.args]
        if node.op == "linear":
            return min(max(inner), self._degree_by_rates(node))
        if node.op == "mul":
            return min(UNBOUNDED, sum(inner))
        return UNBOUNDED

    def _degree_by_rates(self, node: Node) -> int:
        """Degree of a sum of entries whose rates cancel: in stick two masses move as one."""
        if any(arg.index not in self.leaves for arg in node.args):
            return UNBOUNDED
        rates = [self.rates[self.leaves[arg.index]] for arg in node.args]
        rate = self.graph.linear(self.graph.zero, list(zip(node.value[1:], rates, strict=True)))
        return 1 if rate.constant else UNBOUNDED

    def _degree(self, node: Node, degrees: dict[int, int]) -> int:
        return 0 if node.constant else degrees[node.index]

    # --- a loop over orders -----------------------------------------------------------------------
    def _table(self) -> Table | None:
        """What a loop needs of earlier orders; None where there is to be none."""
        endless = {node.index for node in self.nodes if self.degrees[node.index] == UNBOUNDED}
        rates = (self.rates[self.leaves[leaf]] for leaf in self.leaves if leaf in endless)
        factors, kept = {}, {rate.index: rate for rate in rates}
        for node in self.nodes:
            if node.index not in endless or node.op in ("linear", "state"):
                continue
            pair = self._factors(node)
            if pair is None:
                return None
            long = [factor for factor in (pair.left, pair.right) if factor.index in endless]
            if len(long) == 2:
                factors[node.index] = pair
            else:
                kept |= {factor.index: factor for factor in long}
        return Table(factors, kept) if len(factors) >= MANY else None

    def _factors(self, node: Node) -> Factors | None:
        """What is multiplied in the coefficients of `node`, if they are one sum of products."""
        if node.op == "mul":
            return Factors(node.args[0], node.args[1])
        if node.op == "div":
            return Factors(node, node.args[1])
        if node.op in ("sin", "cos"):
            return Factors(node.args[0], self.partners[node.index], by_order=True)
        return Factors(node.args[0], node, by_order=True) if node.op == "exp" else None

    @property
    def _first_looped(self) -> int:
        """The order from which on every order is like the next.

        All that ends has ended, and the ends of a sum of products lie apart.
        """
        return max([4, *(2 + degree for degree in self.degrees.values() if degree < UNBOUNDED)])

    def _write_looped(self, table: Table, first: int, last: int) -> None:
        """All orders from `first` to `last`, row k of the table being that of order k."""
        self.lines.append(f"    for k in range({first}, {last + 1}):")
        begun, self.looped = len(self.lines), first
        self.lines.append("    inverse = 1.0 / k")
        for leaf, position in self.leaves.items():
            if self.degrees[leaf] == UNBOUNDED:
                rate = self._known(self.rates[position], first - 1)
                self._define(f"{self.leaf_names[leaf]}_k", f"{rate} * inverse")
        for node in self.nodes:
            if self.degrees[node.index] == UNBOUNDED and node.index not in self.leaves:
                self._assign(node, first)
        self._write_rows(first)
        self.lines.append(f"    convolve(v, k + 1, {table.width}, {table.stride})")
        self._keep(table, first)
        self.lines[begun:] = [f"    {line}" for line in self.lines[begun:]]
        self.looped = None

    def _keep(self, table: Table, k: int) -> None:
        """Write row k of the table."""

        def put(column: int, text: str) -> None:
            place = table.at(k, column) if self.looped is None else table.back(0, column)
            self.lines.append(f"    {place} = {text}")

        for index, factors in table.factors.items():
            put(table.factor(0, index), self._left(factors, k))
            put(table.factor(1, index), self._known(factors.right, k))
        for index, node in table.kept.items():
            put(table.own(index), self._known(node, k))

    def _left(self, factors: Factors, k: int) -> str:
        """The left factor of order k in a sum of products."""
        weight = f"{float(k)!r} * " if self.looped is None else "k * "
        return (weight if factors.by_order else "") + self._known(factors.left, k)

    def _convolved(self, node: Node, k: int) -> list[str]:
        """In a loop, terms of the sum of products that order k of a node is made of; else none."""
        table = self.table
        if self.looped is None or table is None or node.index not in table.factors:
            return []
        factors = left, right, by_order = table.factors[node.index]
        before = [table.back(1, table.factor(side, node.index)) for side in (0, 1)]
        terms = [table.back(0, table.factor(2, node.index))]
        terms += [f"{self._known(left, 1)} * {before[1]}", f"{before[0]} * {self._known(right, 1)}"]
        if not by_order:
            terms.append(f"{self._known(left, 0)} * {self._known(right, k)}")
        if left is not node:
            terms.append(f"{self._left(factors, k)} * {self._known(right, 0)}")
        return terms

    # --- text -------------------------------------------------------------------------------------
    def text(self, name: str, comment: str) -> list[str]:
        """The whole function."""
        self.lines = [self._head(name), f"    # {comment}; order {self.order}"]
        first = self._first_looped
        if self.table is None or self.order < first:
            for k in range(self.order + 1):
                self._write_order(k)
            return self.lines
        table = self.table
        self.lines.append(f"    v = [0.0] * {(self.order + 2) * table.stride}")
        for k in range(first):
            self._write_order(k)
            if k > 1:
                self._keep(table, k)
        self.lines.append(f"    convolve(v, {first}, {table.width}, {table.stride})")
        for begin, end in self._alike(first):
            if begin <= end:
                self._write_looped(table, begin, end)
        return self.lines

    def _alike(self, first: int) -> list[tuple[int, int]]:
        """First and last orders that are written alike, from `first` on."""
        return [(first, self.order)]

    def _head(self, name: str) -> str:
        return f"def {name}(c, t, y, out):"

    def _write_order(self, k: int) -> None:
        for node in self.nodes if k < self.order else self._needed_for(self._last()):
            if k <= self.degrees[node.index] and not self._is_integrated(node, k):
                self._assign(node, k)
        self._write_rows(k)
        if k < self.order:
            for leaf, position in self.leaves.items():
                self._integrate(leaf, position, k)

    def _last(self) -> list[Node]:
        """What is computed to the highest order: rates would lead further."""
        return [*self.values, *self.outputs]

    def _write_rows(self, k: int) -> None:
        self._write_out([*self.values, *self.outputs], self.order, k)

    def _write_out(self, nodes: Sequence[Node], order: int, k: int) -> None:
        """Order k of the series of `nodes`, which have so many orders."""
        for row, node in enumerate(nodes):
            text = self._known(node, k)
            self.lines.append(f"    {self._place(row * (order + 1), k)} = {text or '0.0'}")

    def _place(self, first: int, k: int) -> str:
        """Where order k of the series that begins at `first` is written."""
        return f"out[{first + k}]" if self.looped is None else f"out[k + {first}]"

    def _is_integrated(self, node: Node, k: int) -> bool:
        return node.index in self.leaves and k > 0

    def _integrate(self, leaf: int, position: int, k: int) -> None:
        """The next coefficient of a state: that of its rate over k + 1."""
        if k + 1 > self.degrees[leaf]:
            return
        rate = self._known(self.rates[position], k) or "0.0"
        self._define(f"{self.leaf_names[leaf]}_{k + 1}", f"{rate}{_over(k + 1)}")

    def _known(self, node: Node, k: int) -> str:
        """Coefficient k of a series as text; empty when it is structurally zero."""
        if node.constant:
            text = self.coefficients.text(node) if k == 0 else ""
            return "" if text == "0.0" else text
        if self.looped is None or k < 2 or self.degrees[node.index] < UNBOUNDED:
            return f"{self.name(node)}_{k}" if k <= self.degrees[node.index] else ""
        if k == self.looped:
            return f"{self.name(node)}_k"
        assert self.table is not None
        return self.table.back(self.looped - k, self.table.own(node.index))

    def _assign(self, node: Node, k: int) -> None:
        order = k if self.looped is None else "k"
        self._define(f"{self.name(node)}_{order}", getattr(self, f"_series_{node.op}")(node, k))
        if node.op == "tanh":
            self._define(f"{self.name(node)}q_{k}", self._one_minus_square(node, k))

    def _define(self, name: str, text: str) -> None:
        self.lines.append(f"    {name} = {text}")
        self.known_at[name] = 1 + self._waits(text)

    def _waits(self, text: str) -> int:
        """Operations after which all that `text` is made of is known, one after the other."""
        waits = 0
        for part in WAITED_FOR.findall(text):
            if part.endswith("("):
                waits += CALL
            else:
                waits = max(waits + WAITS.get(part, 0), self.known_at.get(part, 0))
        return waits

    def _sum(self, terms: Sequence[str]) -> str:
        """Terms joined; those that are known first come first: they wait for no other."""
        return _sum(sorted(terms, key=self._waits))

    def _series_time(self, node: Node, k: int) -> str:
        return "t" if k == 0 else "1.0"

    def _series_state(self, node: Node, k: int) -> str:
        return f"y[{node.value}]"

    def _series_tangent(self, node: Node, k: int) -> str:
        return f"y[{node.value + self.size // 2}]"

    def _series_linear(self, node: Node, k: int) -> str:
        terms = _constant_term(node, self.coefficients) if k == 0 else []
        for weight, arg in zip(node.value[1:], node.args, strict=True):
            known = self._known(arg, k)
            if known:
                terms.append(_weighted(weight, known, self.coefficients))
        return self._sum(terms)

    def _products(self, left: Node, right: Node, k: int, start: int, stop: int) -> list[str]:
        """Terms left_j * right_{k-j}, start <= j < stop, that are not structurally zero."""
        pairs = [(self._known(left, j), self._known(right, k - j)) for j in range(start, stop)]
        return [f"{a} * {b}" for a, b in pairs if a and b]

    def _series_mul(self, node: Node, k: int) -> str:
        left, right = node.args
        if convolved := self._convolved(node, k):
            return self._sum(convolved)
        if left is not right:
            return self._sum(self._products(left, right, k, 0, k + 1))
        return self._square(left, k)

    def _square(self, node: Node, k: int) -> str:
        """Coefficient k of a square: each pair once."""
        pairs = self._products(node, node, k, 0, (k + 1) // 2)
        middle = self._known(node, k // 2) if k % 2 == 0 else ""
        terms = [f"2.0 * ({self._sum(pairs)})"] if pairs else []
        if middle:
            terms.append(f"{middle} * {middle}")
        return self._sum(terms)

    def _series_div(self, node: Node, k: int) -> str:
        above, below = node.args
        rest = [self._known(above, k)] if self._known(above, k) else []
        products = self._convolved(node, k) or self._products(node, below, k, 0, k)
        rest += [f"-{term}" for term in products]
        return f"({self._sum(rest)}) / {self._known(below, 0)}"

    def _series_pow(self, node: Node, k: int) -> str:
        base, exponent = node.args[0], node.value
        if k == 0:
            return f"pow({self._known(base, 0)}, {exponent!r})"
        terms = []
        for j in range(k):
            known = self._known(base, k - j)
            if known:
                terms.append(f"{exponent * (k - j) - j!r} * {known} * {self.name(node)}_{j}")
        return f"({self._sum(terms)}) / ({float(k)!r} * {self._known(base, 0)})"

    def _series_sqrt(self, node: Node, k: int) -> str:
        base = self._known(node.args[0], k)
        if k == 0:
            return f"sqrt({base})"
        rest = ([base] if base else []) + [f"-{t}" for t in self._products(node, node, k, 1, k)]
        return f"({self._sum(rest)}) / (2.0 * {self.name(node)}_0)"

    def _chain(self, node: Node, inner: Node, outer: Node, k: int, sign: str = "") -> str:
        """Sum of j inner_j outer_{k-j} over j = 1..k, divided by k.

        The rate of a linear argument is divided first: it does not wait for the other factor.
        """
        over = _over(k) if self.looped is None else " * inverse"
        if convolved := self._convolved(node, k):
            return f"{sign}({self._sum(convolved)}){over}"
        pairs = [(j, self._known(inner, j), self._known(outer, k - j)) for j in range(1, k + 1)]
        pairs = [pair for pair in pairs if all(pair)]
        if len(pairs) == 1 and self.looped is None:
            [(j, a, b)] = pairs
            return f"{sign}({_times(j / k, a)} * {b})"
        terms = [_times(j, f"{a} * {b}") for j, a, b in pairs]
        return f"{sign}({self._sum(terms)}){over}"

    def _series_exp(self, node: Node, k: int) -> str:
        if k == 0:
            return f"exp({self._known(node.args[0], 0)})"
        return self._chain(node, node.args[0], node, k)

    def _series_log(self, node: Node, k: int) -> str:
        """w' a = a'."""
        argument = node.args[0]
        if k == 0:
            return f"log({self._known(argument, 0)})"
        return self._quotient(argument, node, argument, k)

    def _quotient(self, above: Node, node: Node, below: Node, k: int) -> str:
        """Coefficient k > 0 of a node whose rate is that of `above` over `below`."""
        terms = []
        for j in range(1, k):
            known = self._known(below, k - j)
            if known:
                terms.append(f"{float(j)!r} * {self.name(node)}_{j} * {known}")
        rest = [self._known(above, k)] if self._known(above, k) else []
        rest += [f"-({self._sum(terms)}){_over(k)}"] if terms else []
        return f"({self._sum(rest)}) / {self._known(below, 0)}"

    def _series_sin(self, node: Node, k: int) -> str:
        """The two series need each other's lower orders."""
        argument = node.args[0]
        if k == 0:
            return f"sin({self._known(argument, 0)})"
        return self._chain(node, argument, self.partners[node.index], k)

    def _series_cos(self, node: Node, k: int) -> str:
        argument = node.args[0]
        if k == 0:
            return f"cos({self._known(argument, 0)})"
        return self._chain(node, argument, self.partners[node.index], k, "-")

    def _series_asin(self, node: Node, k: int) -> str:
        """w' q = a' with q = sqrt(1 - a^2)."""
        argument, root = node.args[0], self.partners[node.index]
        if k == 0:
            return f"asin({self._known(argument, 0)})"
        return self._quotient(argument, node, root, k)

    def _series_tanh(self, node: Node, k: int) -> str:
        """w' = (1 - w^2) a'."""
        argument = node.args[0]
        if k == 0:
            return f"tanh({self._known(argument, 0)})"
        terms = []
        for j in range(1, k + 1):
            known = self._known(argument, j)
            if known:
                terms.append(f"{float(j)!r} * {known} * {self.name(node)}q_{k - j}")
        return f"({self._sum(terms)}){_over(k)}"

    def _one_minus_square(self, node: Node, k: int) -> str:
        return f"{'1.0 ' if k == 0 else ''}- ({self._square(node, k)})"


class FollowedStep(TaylorStep):
    """A Taylor step that writes, behind the series of a usual one, what tangents need.

    Parameters
    ----------
    order : of the series that a usual step writes
    extra : further orders of what tangents need
    """

    def __init__(
        self,
        graph: Graph,
        values: Sequence[Node],
        rates: Sequence[Node],
        outputs: Sequence[Node],
        order: int,
        extra: int,
        coefficients: Coefficients,
    ) -> None:
        self.tangents = [*map(graph.tangent, values)], [*map(graph.tangent, rates)]
        self._read = _split(reachable(node for part in self.tangents for node in part))[1]
        super().__init__(graph, values, rates, outputs, order + extra, coefficients)
        self.shown = order
        # Numbers that are written.
        self.length = (len(self.values) + len(self.outputs)) * (order + 1)
        self.rows: dict[int, int] = {}  # where the series of what is needed begin
        self.needed: dict[int, dict[int, Node]] = {}  # order -> what is needed to this order

    def _needed_for(self, roots: Sequence[Node]) -> list[Node]:
        return super()._needed_for([*roots, *self._read])

    def place(self, node: Node, k: int) -> int:
        """Where coefficient k of `node` is, which is written from now on."""
        if node.index not in self.rows:
            self.rows[node.index] = self.length
            self.length += self.order + 1
        self.needed.setdefault(k, {})[node.index] = node
        return self.rows[node.index] + k

    def text(self, name: str, comment: str) -> list[str]:
        self.order = max([self.shown, *self.needed])
        return super().text(name, comment)

    def _shown(self, k: int) -> list[Node]:
        """What is written as a usual step does."""
        return [*self.values, *self.outputs] if k <= self.shown else []

    def _last(self) -> list[Node]:
        return [*self._shown(self.order), *self.needed.get(self.order, {}).values()]

    def _alike(self, first: int) -> list[tuple[int, int]]:
        return [(first, self.shown), (self.shown + 1, self.order)]

    def _write_rows(self, k: int) -> None:
        self._write_out(self._shown(k), self.shown, k)
        for index, node in self._needed(k).items():
            if known := self._known(node, k):
                self.lines.append(f"    {self._place(self.rows[index], k)} = {known}")

    def _needed(self, k: int) -> dict[int, Node]:
        """What is written to order k; in a loop, all that is needed to any order."""
        if self.looped is None:
            return self.needed.get(k, {})
        return {i: node for needed in self.needed.values() for i, node in needed.items()}


class TangentStep(TaylorStep):
    """Writes the series of tangent vectors; what they need of the motion's series is read.

    Parameters
    ----------
    motion : of which these are tangents; what is read has its places in what that one writes
    """

    def __init__(self, graph: Graph, motion: FollowedStep) -> None:
        self.motion = motion
        self._own: set[int] = set()  # what depends on a tangent vector
        super().__init__(graph, *motion.tangents, [], motion.order, motion.coefficients)

    def _needed_for(self, roots: Sequence[Node]) -> list[Node]:
        own = _split(reachable(roots))[0]
        self._own.update(node.index for node in own)
        return own

    def _table(self) -> None:
        return None

    def _is_own_leaf(self, node: Node, position: int) -> bool:
        return node.op == "tangent" and node.value == position

    def _degree(self, node: Node, degrees: dict[int, int]) -> int:
        is_own = node.constant or node.index in self._own
        return super()._degree(node, degrees if is_own else self.motion.degrees)

    def _head(self, name: str) -> str:
        return f"def {name}(c, t, y, lanes):"

    def _known(self, node: Node, k: int) -> str:
        if node.constant or node.index in self._own:
            return super()._known(node, k)
        return f"y[{self.motion.place(node, k)}]" if k <= self.motion.degrees[node.index] else ""

    def _series_tangent(self, node: Node, k: int) -> str:
        return f"lanes[{node.value * (self.order + 1)}]"

    def _write_rows(self, k: int) -> None:
        for row, node in enumerate(self.values):
            if k > 0 or node.index not in self.leaves:
                text = self._known(node, k) or "0.0"
                self.lines.append(f"    lanes[{row * (self.order + 1) + k}] = {text}")


def _split(nodes: Iterable[Node]) -> tuple[list[Node], list[Node]]:
    """Those that depend on a tangent vector, arguments first, and what else these depend on."""
    own: dict[int, Node] = {}
    others: dict[int, Node] = {}
    for node in nodes:
        if node.op == "tangent" or any(arg.index in own for arg in node.args):
            own[node.index] = node
            others |= {arg.index: arg for arg in node.args if arg.index not in own}
    return list(own.values()), [node for node in others.values() if not node.constant]


def _partner(graph: Graph, node: Node) -> Node:
    return PARTNER[node.op](graph, node.args[0])


def _with_partners(graph: Graph, roots: Sequence[Node]) -> list[Node]:
    """What `roots` depend on and, for each function there that needs a partner, that one."""
    extra = [_partner(graph, node) for node in reachable(roots) if node.op in PARTNER]
    return reachable([*roots, *extra])
