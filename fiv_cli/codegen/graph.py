"""An expression graph in which equal subexpressions are one node.

SymPy trees come in, straight-line code goes out. Nodes that depend on parameters alone are
*constant*: they are computed once per run, not once per step. Sums are kept as linear
combinations with constant weights, so a mass or a stiffness never costs an operation per order.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

if TYPE_CHECKING:
    from sympy import Expr

UNARY = ("exp", "log", "sqrt", "sin", "cos", "tanh", "asin")


@dataclass(frozen=True, eq=False)
class Node:
    """One operation.

    Attributes
    ----------
    index : position in the graph; arguments come before their users
    op : "number", "parameter", "time", "state", "tangent", "linear", "mul", "div", "pow" or
        one of `UNARY`
    args : argument nodes; for "linear": term nodes
    value : number, name, exponent; for "linear": the weights, constant term first
    constant : depends on parameters alone
    """

    index: int
    op: str
    args: tuple[Node, ...]
    value: Any
    constant: bool


def reachable(roots: Iterable[Node]) -> list[Node]:
    """Varying nodes that `roots` depend on, arguments first."""
    found: dict[int, Node] = {}
    stack = [root for root in roots if not root.constant]
    while stack:
        node = stack.pop()
        if node.index not in found:
            found[node.index] = node
            stack.extend(arg for arg in node.args if not arg.constant)
    return [found[index] for index in sorted(found)]


class Graph:
    """Builds nodes, each once."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._known: dict[tuple[object, ...], Node] = {}
        self._tangents: dict[int, Node] = {}
        self._multiples: dict[int, tuple[str, Node]] = {}  # what a sum or product is the sine of
        self._names: dict[int, str] = {}
        self._short = 1  # terms of a sum that is merged into another one where both are built
        self.zero = self.number(0.0)
        self.one = self.number(1.0)

    # --- leaves -------------------------------------------------------------------------
    def number(self, value: float) -> Node:
        """A literal."""
        return self._node("number", (), float(value) + 0.0, True)

    def parameter(self, name: str) -> Node:
        """A parameter, a sign of slip or the zone: constant within a contact state."""
        return self._node("parameter", (), name, True)

    def time(self) -> Node:
        """Time, s."""
        return self._node("time", (), None, False)

    def state(self, position: int, name: str) -> Node:
        """Entry of the state vector, called `name` in the generated text."""
        node = self._node("state", (), position, False)
        self._names[node.index] = name
        return node

    def name(self, node: Node) -> str:
        """What `node` is called in the generated text."""
        return self._names.get(node.index, f"n{node.index}")

    # --- sums and products ----------------------------------------------------------------
    def linear(self, constant: Node, terms: Sequence[tuple[Node, Node]]) -> Node:
        """``constant + sum(weight * node)``; weights and constant are constant nodes."""
        weights: dict[int, Node] = {}
        members: dict[int, Node] = {}
        for weight, node in terms:
            constant = self._gather(constant, weight, node, weights, members)
        kept = [i for i in sorted(members) if not _is(weights[i], 0.0)]
        if not kept:
            return constant
        if len(kept) == 1 and _is(constant, 0.0) and _is(weights[kept[0]], 1.0):
            return members[kept[0]]
        value = (constant, *(weights[i] for i in kept))
        return self._node("linear", tuple(members[i] for i in kept), value, False)

    def _gather(
        self,
        constant: Node,
        weight: Node,
        node: Node,
        weights: dict[int, Node],
        members: dict[int, Node],
    ) -> Node:
        """Add one term, merging an inner one; returns the new constant term."""
        if node.constant:
            return self._constant_sum(constant, self._constant_product(weight, node))
        if node.op == "linear" and len(node.args) <= self._short:
            constant = self._constant_sum(constant, self._constant_product(weight, node.value[0]))
            inner = zip(node.value[1:], node.args, strict=True)
            pairs = [(self._constant_product(weight, w), a) for w, a in inner]
        else:
            pairs = [(weight, node)]
        for w, a in pairs:
            members[a.index] = a
            old = weights.get(a.index)
            weights[a.index] = w if old is None else self._constant_sum(old, w)
        return constant

    @contextmanager
    def merging(self, terms: int) -> Iterator[None]:
        """Merge sums of up to so many `terms` here: what cancels then does, to the last digit."""
        self._short, before = terms, self._short
        yield
        self._short = before

    def merged(self, roots: Sequence[Node]) -> list[Node]:
        """`roots` with inner sums merged into outer ones where that costs nothing.

        A sum that several others contain is cheaper computed once (the normal force of a disc
        enters every modal equation), one of few terms or in one place is not.
        """
        nodes = reachable(roots)
        uses = Counter(arg.index for node in nodes if node.op == "linear" for arg in node.args)
        shared = {arg.index for node in nodes if node.op != "linear" for arg in node.args}
        shared |= {root.index for root in roots}
        new: dict[int, Node] = {}
        for node in nodes:
            args = [new.get(arg.index, arg) for arg in node.args]
            if node.op == "linear":
                new[node.index] = self._rebuilt(node, args, shared)
            else:
                new[node.index] = self._node(node.op, tuple(args), node.value, node.constant)
            count, times = len(new[node.index].args), uses[node.index]
            if count > 2 and count * times > count + times:
                shared.add(node.index)
        return [new.get(root.index, root) for root in roots]

    def _rebuilt(self, node: Node, args: Sequence[Node], shared: set[int]) -> Node:
        """A sum of these new arguments, with those merged whose old ones are not shared."""
        terms, constant = [], node.value[0]
        for weight, old, arg in zip(node.value[1:], node.args, args, strict=True):
            if arg.op != "linear" or old.index in shared:
                terms.append((weight, arg))
                continue
            constant = self._constant_sum(constant, self._constant_product(weight, arg.value[0]))
            pairs = zip(arg.value[1:], arg.args, strict=True)
            terms += [(self._constant_product(weight, w), a) for w, a in pairs]
        return self.linear(constant, terms)

    def add(self, *nodes: Node) -> Node:
        """Sum."""
        return self.linear(self.zero, [(self.one, node) for node in nodes])

    def negative(self, node: Node) -> Node:
        """Minus `node`."""
        return self.mul(self.number(-1.0), node)

    def subtract(self, left: Node, right: Node) -> Node:
        """``left - right``."""
        return self.linear(self.zero, [(self.one, left), (self.number(-1.0), right)])

    def mul(self, left: Node, right: Node) -> Node:
        """Product; a constant factor becomes a weight."""
        if left.constant and right.constant:
            return self._constant_product(left, right)
        if left.constant:
            return self.linear(self.zero, [(left, right)])
        if right.constant:
            return self.linear(self.zero, [(right, left)])
        return self._bare_product(left, right)

    def _bare_product(self, left: Node, right: Node) -> Node:
        """Product of two varying nodes, with constant weights of either pulled out."""
        weight = self.one
        factors = []
        for node in (left, right):
            if node.op == "linear" and len(node.args) == 1 and _is(node.value[0], 0.0):
                weight = self._constant_product(weight, node.value[1])
                node = node.args[0]
            factors.append(node)
        factors.sort(key=lambda node: node.index)
        product = self._node("mul", tuple(factors), None, False)
        return self.linear(self.zero, [(weight, product)])

    def div(self, numerator: Node, denominator: Node) -> Node:
        """Quotient; division by a constant becomes a weight."""
        if denominator.constant:
            inverse = self._constant_quotient(self.one, denominator)
            if numerator.constant:
                return self._constant_quotient(numerator, denominator)
            return self.linear(self.zero, [(inverse, numerator)])
        return self._node("div", (numerator, denominator), None, False)

    def power(self, base: Node, exponent: float) -> Node:
        """`base` to a fixed exponent: products for small whole ones."""
        if exponent == 0.0:
            return self.one
        if exponent < 0.0:
            return self.div(self.one, self.power(base, -exponent))
        if exponent == 0.5:
            return self.unary("sqrt", base)
        if exponent == int(exponent) and exponent <= 8:
            return self._whole_power(base, int(exponent))
        return self._node("pow", (base,), float(exponent), base.constant)

    def _whole_power(self, base: Node, exponent: int) -> Node:
        if exponent == 1:
            return base
        half = self._whole_power(base, exponent // 2)
        square = self.mul(half, half)
        return self.mul(square, base) if exponent % 2 else square

    def unary(self, op: str, argument: Node) -> Node:
        """One of `UNARY`."""
        if argument.op == "number":
            return self.number(getattr(math, op)(argument.value))
        if op in ("sin", "cos") and (times := _multiple(argument)) > 1:
            return self._of_multiple(op, argument.args[0], times)
        return self._node(op, (argument,), None, argument.constant)

    def _of_multiple(self, op: str, angle: Node, times: int) -> Node:
        """Sine or cosine of a whole multiple of an angle: a product of those of lower ones."""

        def lower(op: str, count: int) -> Node:
            return self.unary(op, self.mul(self.number(count), angle))

        two, half = self.number(2.0), times // 2
        if times % 2:
            product = self.mul(self.unary("cos", angle), lower(op, times - 1))
            found = self.subtract(self.mul(two, product), lower(op, times - 2))
        elif op == "sin":
            found = self.mul(two, self.mul(lower("sin", half), lower("cos", half)))
        else:
            square = self.power(lower("sin", half), 2.0)
            found = self.subtract(self.one, self.mul(two, square))
        self._multiples[found.index] = op, self.mul(self.number(times), angle)
        return found

    # --- constants ------------------------------------------------------------------------
    def _constant_sum(self, left: Node, right: Node) -> Node:
        if left.op == "number" and right.op == "number":
            return self.number(left.value + right.value)
        if _is(left, 0.0):
            return right
        if _is(right, 0.0):
            return left
        return self._node("add_constant", (left, right), None, True)

    def _constant_product(self, left: Node, right: Node) -> Node:
        if left.op == "number" and right.op == "number":
            return self.number(left.value * right.value)
        for one, other in ((left, right), (right, left)):
            if _is(one, 0.0):
                return self.zero
            if _is(one, 1.0):
                return other
        if left.index > right.index:
            left, right = right, left
        return self._node("mul_constant", (left, right), None, True)

    def _constant_quotient(self, left: Node, right: Node) -> Node:
        if left.op == "number" and right.op == "number":
            return self.number(left.value / right.value)
        if _is(right, 1.0):
            return left
        return self._node("div_constant", (left, right), None, True)

    # --- from SymPy -----------------------------------------------------------------------
    def build(self, expression: Expr, names: Mapping[Expr, Node]) -> Node:
        """The node of a SymPy expression; `names` maps its free symbols to nodes."""
        return self._build(sympy.sympify(expression), names, {})

    def _build(self, expression: Expr, names: Mapping[Expr, Node], done: dict[Expr, Node]) -> Node:
        node = done.get(expression)
        if node is None:
            node = self._convert(expression, names, done)
            done[expression] = node
        return node

    def _convert(
        self, expression: Expr, names: Mapping[Expr, Node], done: dict[Expr, Node]
    ) -> Node:
        if expression.is_Symbol:
            return names[expression]
        if expression.is_number:
            return self.number(float(expression))
        if expression.is_Add:
            return self.add(*(self._build(arg, names, done) for arg in expression.args))
        if expression.is_Mul:
            return self._quotient(expression, names, done)
        if expression.is_Pow and expression.exp.is_number:
            return self.power(self._build(expression.base, names, done), float(expression.exp))
        if expression.is_Pow:
            base, exponent = (self._build(arg, names, done) for arg in expression.args)
            return self.unary("exp", self.mul(exponent, self.unary("log", base)))
        op = expression.func.__name__
        if op not in UNARY:
            raise NotImplementedError(f"no series for {expression.func} in {expression}")
        return self.unary(op, self._build(expression.args[0], names, done))

    def _quotient(self, product: Expr, names: Mapping[Expr, Node], done: dict[Expr, Node]) -> Node:
        """A product with its negative powers collected in one denominator.

        Constant factors come last: products that differ in them alone are one node.
        """
        weight, above, below = self.one, self.one, self.one
        for factor in product.args:
            if factor.is_Pow and factor.exp.is_number and factor.exp.is_negative:
                node = self.power(self._build(factor.base, names, done), -float(factor.exp))
                below = self.mul(below, node)
                continue
            node = self._build(factor, names, done)
            if node.constant:
                weight = self.mul(weight, node)
            else:
                above = self.mul(above, node)
        above = self.mul(weight, above)
        return self.div(above, below) if below is not self.one else above

    # --- derivatives ----------------------------------------------------------------------
    def tangent(self, node: Node) -> Node:
        """Directional derivative of `node` along the tangent vector."""
        known = self._tangents.get(node.index)
        if known is None:
            known = self.zero if node.constant or node.op == "time" else self._differentiate(node)
            self._tangents[node.index] = known
        return known

    def _differentiate(self, node: Node) -> Node:
        if node.op == "state":
            tangent = self._node("tangent", (), node.value, False)
            self._names[tangent.index] = f"d_{self.name(node)}"
            return tangent
        if node.index in self._multiples:
            op, argument = self._multiples[node.index]
            other = self.unary("cos" if op == "sin" else "sin", argument)
            slope = other if op == "sin" else self.negative(other)
            return self.mul(slope, self.tangent(argument))
        inner = [self.tangent(arg) for arg in node.args]
        if node.op == "linear":
            return self.linear(self.zero, list(zip(node.value[1:], inner, strict=True)))
        if node.op == "mul":
            left, right = node.args
            return self.add(self.mul(inner[0], right), self.mul(left, inner[1]))
        if node.op == "div":
            rest = self.subtract(inner[0], self.mul(node, inner[1]))
            return self.div(rest, node.args[1])
        return self.mul(self._slope(node), inner[0])

    def _slope(self, node: Node) -> Node:
        """Derivative of a function of one argument with respect to it."""
        argument = node.args[0]
        if node.op == "pow":
            return self.mul(self.number(node.value), self.power(argument, node.value - 1.0))
        if node.op == "exp":
            return node
        if node.op == "log":
            return self.div(self.one, argument)
        if node.op == "sqrt":
            return self.div(self.number(0.5), node)
        if node.op == "sin":
            return self.unary("cos", argument)
        if node.op == "cos":
            return self.negative(self.unary("sin", argument))
        if node.op == "asin":
            return self.div(self.one, self.cosine_of_asin(argument))
        return self.subtract(self.one, self.mul(node, node))  # tanh

    def cosine_of_asin(self, argument: Node) -> Node:
        """``sqrt(1 - argument^2)``: one over the slope of asin."""
        return self.unary("sqrt", self.subtract(self.one, self.mul(argument, argument)))

    def _node(self, op: str, args: tuple[Node, ...], value: Any, constant: bool) -> Node:
        key = (op, tuple(arg.index for arg in args), _hashable(value))
        node = self._known.get(key)
        if node is None:
            node = Node(len(self.nodes), op, args, value, constant)
            self.nodes.append(node)
            self._known[key] = node
        return node


def _multiple(node: Node) -> int:
    """How many times another node this one is, if so many whole times; else 1."""
    if node.op != "linear" or len(node.args) > 1 or not _is(node.value[0], 0.0):
        return 1
    weight = node.value[1]
    return int(weight.value) if weight.op == "number" and weight.value in range(2, 100) else 1


def _is(node: Node, value: float) -> bool:
    return node.op == "number" and node.value == value


def _hashable(value: object) -> object:
    if isinstance(value, tuple):
        return tuple(item.index for item in value)
    return value
