"""Generated code: the text is the program, series and derivatives are exact."""

from __future__ import annotations

import ast
import cmath
import ctypes
import math
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import product
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from motions import defaults, system
from numpy.typing import NDArray
from small_models import BOUNCER, TWO_MASSES

from fiv_cli.codegen import assembly, lower
from fiv_cli.codegen.codes import LANES, NODES, OTHER_POWER
from fiv_cli.codegen.emit import Coefficients, TaylorStep
from fiv_cli.codegen.gather import gathered
from fiv_cli.codegen.generate import FLOW, JACOBIAN, TANGENT, StateTable
from fiv_cli.codegen.graph import UNARY, Graph, Node
from fiv_cli.dynamics.system import System

Vector = NDArray[Any]
T = sympy.Symbol("t", real=True)
ORDER = 14
POINTER = ctypes.POINTER(ctypes.c_double)
FUNCTION = ctypes.CFUNCTYPE(None, POINTER, ctypes.c_double, POINTER, POINTER)

SYSTEMS = [
    ("belt-1dof", "coulomb", {"u0": 0.5, "omega": 0.85, "c": 0.1}),
    ("belt-1dof", "stribeck", {"u0": 0.5, "omega": 0.85, "c": 0.1}),
    ("belt-1dof", "linear-slope", {"u0": 0.5}),
    ("belt-1dof", "hyperbolic", {"u0": 0.5}),
    ("belt-1dof", "tanh of stribeck", {"u0": 0.5, "sigma": 3.0}),
    ("pin-on-disc", "coulomb", {"beta": 1.0}),
    (BOUNCER, "coulomb", {"A": 1.5, "k_z": 3.0}),
    (TWO_MASSES, "coulomb", {}),
]
LOOPING = ("disc-nonlinear-contact", "coulomb", {})  # goes through orders in a loop
IDS = [f"{m if isinstance(m, str) else m.name} {law}" for m, law, _ in (*SYSTEMS, LOOPING)]
every_system = pytest.mark.parametrize(("model", "law", "changes"), SYSTEMS, ids=IDS[:-1])
and_looping = pytest.mark.parametrize(("model", "law", "changes"), [*SYSTEMS, LOOPING], ids=IDS)


class Fused(ast.NodeTransformer):
    """A sum with a product as one operation with one rounding: what a compiled text computes."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Add | ast.Sub):
            return node
        subtracts = isinstance(node.op, ast.Sub)
        if is_product(node.right):
            return fma_call(node.right.left, node.right.right, node.left, subtracts)
        if is_product(node.left):
            added = ast.UnaryOp(ast.USub(), node.right) if subtracts else node.right
            return fma_call(node.left.left, node.left.right, added, False)
        return node


def is_product(node: ast.expr) -> bool:
    """Whether the last operation of an expression multiplies."""
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)


def fma_call(a: ast.expr, b: ast.expr, added: ast.expr, negated: bool) -> ast.Call:
    """``fma(a, b, added)``, or with -a."""
    a = ast.UnaryOp(ast.USub(), a) if negated else a
    return ast.Call(ast.Name("fma", ast.Load()), [a, b, added], [])


def fma(a: float, b: float, added: float) -> float:
    """a b + added, rounded once."""
    exact = Fraction(a) * Fraction(b) + Fraction(added)
    return float(exact) if exact else a * b + added


def python_functions(text: str, library: Any = math) -> dict[str, Any]:
    """The functions of generated text, run by Python itself, rounded as the compiled ones are."""
    space = {name: getattr(library, name) for name in UNARY}
    space |= {"pow": pow, "fma": fma, "rint": round}
    space["convolve"] = partial(convolve, add=fma if library is math and lower.fuses() else plain)
    tree = ast.parse(text)
    if library is math and lower.fuses():
        tree = ast.fix_missing_locations(Fused().visit(tree))
    exec(compile(tree, "<generated>", "exec"), space)
    return space


def plain(a: float, b: float, added: float) -> float:
    """a b + added."""
    return a * b + added


def convolve(v: list[float], order: int, width: int, stride: int, add: Any) -> None:
    """Sums of the products of rows 2 to order - 2 of a table with rows order - 2 to 2."""
    for at in range(width):
        total = 0.0
        for j in range(2, order - 1):
            total = add(v[j * stride + at], v[(order - j) * stride + width + at], total)
        v[order * stride + 2 * width + at] = total


def compiled_call(address: int, c: Vector, t: float, y: Vector, out: Vector) -> None:
    """Call one compiled function."""
    c_data, y_data, out_data = (array.ctypes.data_as(POINTER) for array in (c, y, out))
    FUNCTION(address)(c_data, t, y_data, out_data)


def generated(model: Any, law: str, changes: Any) -> tuple[System, Vector]:
    """A system, and its array ``c`` from the text run by Python."""
    parameters = defaults(model, law, **changes)
    built = system(model, law, parameters=parameters)
    out = np.zeros(max(built.generated.n_coefficients, 1))
    coefficients = python_functions(built.generated.texts[FLOW])["coefficients"]
    coefficients(None, 0.0, built.parameter_vector(parameters), out)
    return built, out


def sizes(built: System) -> int:
    """Enough room for the output of any function but those of tangents."""
    room = 4 * (len(built.state_names) + 12) * (built.generated.order + 1)
    return max(room, built.generated.n_followed)


Address = Callable[[str], int]


def tangents_by(address: Address, built: System, table: StateTable, c: Vector) -> Vector:
    """Series of `directions` beside those of the motion, by compiled code."""
    n, series, lanes = len(built.state_names), np.zeros(sizes(built)), directions(built)
    compiled_call(address(f"{table.name}_followed"), c, 0.7, states(n), series)
    compiled_call(address(f"{table.name}_tangent"), c, 0.7, series, lanes)
    return lanes


def states(count: int) -> Vector:
    """Numbers without symmetry."""
    return np.cos(np.arange(count) + 0.3)


def directions(built: System) -> Vector:
    """Tangent vectors at the beginning of their series; shape (n_states, orders, LANES)."""
    n = len(built.state_names)
    lanes = np.zeros((n, built.generated.tangent_order + 1, LANES))
    lanes[:, 0] = np.sin(np.arange(n * LANES) + 1.1).reshape(n, LANES)
    return lanes


@and_looping
def test_compiled_code_computes_what_its_text_says(model: Any, law: str, changes: Any) -> None:
    built, c = generated(model, law, changes)
    state = np.cos(np.arange(2 * len(built.state_names)) + 0.3)
    suffixes = {
        FLOW: ("taylor", "field"),
        TANGENT: ("followed", "switching"),
        JACOBIAN: ("jacobian",),
    }
    for part in suffixes:
        functions = python_functions(built.generated.texts[part])
        for table, suffix in product(built.generated.states.values(), suffixes[part]):
            name = f"{table.name}_{suffix}"
            by_python, by_machine = np.zeros(sizes(built)), np.zeros(sizes(built))
            functions[name](c, 0.7, state, by_python)
            compiled_call(built.generated.address(name, part), c, 0.7, state, by_machine)
            assert np.count_nonzero(by_python) > 0
            assert by_python.tobytes() == by_machine.tobytes()


@and_looping
def test_every_lane_of_tangents_is_what_the_text_says(model: Any, law: str, changes: Any) -> None:
    built, c = generated(model, law, changes)
    text = python_functions(built.generated.texts[TANGENT])
    address = partial(built.generated.address, part=TANGENT)
    n, series = len(built.state_names), np.zeros(sizes(built))
    for table in built.generated.states.values():
        by_machine, time = tangents_by(address, built, table, c), 0.01
        text[f"{table.name}_followed"](c, 0.7, states(n), series)
        summed = by_machine.copy()
        compiled_call(address("moved"), c, time, series, summed)
        for lane in range(LANES):
            by_python = directions(built)[:, :, lane].ravel()
            text[f"{table.name}_tangent"](c, 0.7, series, by_python)
            assert by_python.tobytes() == by_machine[:, :, lane].tobytes()
            text["moved"](c, time, series, by_python)
            assert by_python.tobytes() == summed[:, :, lane].tobytes()


@every_system
def test_what_is_measured_along_a_step_is_what_the_field_is(
    model: Any, law: str, changes: Any
) -> None:
    built, c = generated(model, law, changes)
    address, n, times = built.generated.address, len(built.state_names), [0.0, 0.01, 0.02, 0.05]
    for index, table in built.generated.states.items():
        series, lanes = np.zeros(sizes(built)), np.zeros((sizes(built), LANES))
        compiled_call(address(f"{table.name}_taylor"), c, 0.7, states(n), series)
        lanes[0] = times
        compiled_call(address(f"{table.name}_measured"), c, 0.7, series, lanes)
        for lane, time in enumerate(times):
            state = np.zeros(n)
            compiled_call(address("state"), c, time, series, state)
            field = built.field(index, c, 0.7 + time, state)
            expected = [*field.state, *field.rates, *field.energies[OTHER_POWER:]]
            assert np.array(expected).tobytes() == lanes[: len(expected), lane].tobytes()


@every_system
def test_powers_along_a_step_are_those_of_the_field(model: Any, law: str, changes: Any) -> None:
    built, c = generated(model, law, changes)
    address, begin = built.generated.address, 40.0
    times = np.linspace(0.0, 0.05, NODES)
    for index, table in built.generated.states.items():
        series, nodes = np.zeros(sizes(built)), np.zeros((sizes(built), NODES))
        y = states(len(built.state_names))
        compiled_call(address(f"{table.name}_taylor"), c, begin, y, series)
        nodes[0] = times
        compiled_call(address(f"{table.name}_powers"), c, begin, series, nodes)
        state = np.zeros(len(built.state_names))
        for node, time in enumerate(times):
            compiled_call(address("state"), c, time, series, state)
            expected = built.field(index, c, begin + time, state).energies[OTHER_POWER:]
            scale = 1e-14 * np.abs(expected).max()
            assert np.allclose(nodes[: len(expected), node], expected, rtol=1e-13, atol=scale)


@every_system
@pytest.mark.parametrize(("piece", "large"), [(1, 0), (40, 10**9), (1000, 10**9)])
def test_a_function_cut_into_pieces_gives_the_same_bits(
    model: Any, law: str, changes: Any, piece: int, large: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However short the pieces, and compiled with or without effort."""
    built, c = generated(model, law, changes)
    state = states(len(built.state_names))
    whole_tangents = partial(built.generated.address, part=TANGENT)
    whole_tangents("moved")
    monkeypatch.setattr(assembly, "WHOLE", 0)
    monkeypatch.setattr(assembly, "PIECE", piece)
    monkeypatch.setattr(lower, "LARGE", large)
    flow, tangent = (
        lower.load_object(lower.compile_text(built.generated.texts[part]))
        for part in (FLOW, TANGENT)
    )
    cut = assembly.assembly(built.generated.texts[TANGENT], fused=True)
    for table in built.generated.states.values():
        whole, pieces = np.zeros(sizes(built)), np.zeros(sizes(built))
        name = f"{table.name}_taylor"
        compiled_call(built.generated.address(name), c, 0.7, state, whole)
        compiled_call(flow.get_function_address(name), c, 0.7, state, pieces)
        assert np.count_nonzero(whole) > 0
        assert whole.tobytes() == pieces.tobytes()
        assert f"call void @{table.name}_followed.1(" in cut
        whole = tangents_by(whole_tangents, built, table, c)
        pieces = tangents_by(tangent.get_function_address, built, table, c)
        assert np.count_nonzero(whole) > 0
        assert whole.tobytes() == pieces.tobytes()


# Every rule of the grammar, names that are bound twice, and values that go through memory.
GRAMMAR = """
def all_rules(c, t, y, out):
    # a comment
    a = y[0] * c[1] - -1.5e-05 / y[1]  # another
    out[3] = a
    b = -a * t + (y[0] - (t + 2.0) * a) * 0.5
    out[0] = b
    a = -(b - a) / c[0] - pow(y[1], -0.5) + sqrt(c[1])
    out[1] = -a - -b
    b = exp(a) * sin(b + t) * cos(b + t) - b - a - 1.0
    out[2] = b * a
    out[4] = 0.0
"""


@pytest.mark.parametrize("piece", [1, 60, 10**9])
@pytest.mark.parametrize("fused", [True, False])
def test_text_means_what_it_means_in_python(
    piece: int, fused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if fused and not lower.fuses():
        pytest.skip("this processor rounds twice")
    monkeypatch.setattr(lower, "fuses", lambda: fused)
    monkeypatch.setattr(assembly, "WHOLE", 0)
    monkeypatch.setattr(assembly, "PIECE", piece)
    engine = lower.load_object(lower.compile_text(GRAMMAR))
    c, y = np.array([0.7, 1.9]), np.array([0.3, 2.2])
    by_python, by_machine = np.zeros(5), np.zeros(5)
    python_functions(GRAMMAR)["all_rules"](c, 0.1, y, by_python)
    compiled_call(engine.get_function_address("all_rules"), c, 0.1, y, by_machine)
    assert by_python.tobytes() == by_machine.tobytes()


@pytest.mark.parametrize(
    "statement", ["out[0] = y[0] ** 2.0", "out[0] = y[0] + ", "out[0] = y[0] t"]
)
def test_text_outside_the_grammar_is_refused(statement: str) -> None:
    with pytest.raises((ValueError, IndexError, KeyError)):
        assembly.assembly(f"def f(c, t, y, out):\n    {statement}\n", fused=True)


@every_system
def test_the_jacobian_is_the_first_order_of_the_tangents(
    model: Any, law: str, changes: Any
) -> None:
    built, c = generated(model, law, changes)
    n, address = len(built.state_names), partial(built.generated.address, part=TANGENT)
    for index, table in built.generated.states.items():
        series, linear = tangents_by(address, built, table, c), np.zeros(sizes(built))
        joined = np.append(states(n), directions(built)[:, 0, 0])
        compiled_call(built.jacobians[index], c, 0.7, joined, linear)
        assert series[:, :2, 0].tobytes() == linear[2 * n : 4 * n].tobytes()


@every_system
def test_tangents_are_directional_derivatives(model: Any, law: str, changes: Any) -> None:
    """A complex step through the flow's series: no difference, no cancellation."""
    built, c = generated(model, law, changes)
    n, size = len(built.state_names), built.generated.order + 1
    state, direction = states(n), directions(built)[:, 0, 0]
    flow = python_functions(built.generated.texts[FLOW], cmath)
    tangent = python_functions(built.generated.texts[TANGENT])
    address = partial(built.generated.address, part=TANGENT)
    step = 1e-30
    for table in built.generated.states.values():
        rows = n + len(table.guards) + table.has_angle
        along, switching = np.zeros(sizes(built), complex), np.zeros(sizes(built))
        flow[f"{table.name}_taylor"](c, 0.7, state + 1j * step * direction, along)
        expected = (along.imag / step)[: rows * size].reshape(rows, size)
        series = tangents_by(address, built, table, c)[:, :, 0]
        tangent[f"{table.name}_switching"](c, 0.7, np.concatenate([state, direction]), switching)
        at_event = switching[: 4 * rows].reshape(2 * rows, 2)
        scale = np.max(np.abs(expected))
        assert scale > 0.0
        pairs = (
            (series[:, :size], expected[:n]),
            (at_event[n : 2 * n], expected[:n, :2]),
            (at_event[n + rows :], expected[n:, :2]),
        )
        for found, wanted in pairs:
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12 * scale)


# --- series ------------------------------------------------------------------------------------
def series_of(expression: Any, at: float, order: int = ORDER) -> Vector:
    """Taylor coefficients of a function of time, by generated text."""
    graph = Graph()
    start = graph.state(0, "s")
    node = graph.build(expression, {T: graph.time()})
    slots = Coefficients()
    step = TaylorStep(graph, [start], [graph.zero], [node], order, slots)
    out = np.zeros(2 * (order + 1))
    text = "\n".join(step.text("f", "series"))
    python_functions(text)["f"](np.zeros(1), at, np.zeros(1), out)
    return out[order + 1 :]


def expected_series(expression: Any, at: float, order: int = ORDER) -> Vector:
    """The same by mpmath, with 60 digits."""
    with mpmath.workdps(60):
        function = sympy.lambdify(T, expression, "mpmath")
        return np.array([float(x) for x in mpmath.taylor(function, mpmath.mpf(at), order)])


INNER = T**2 / 3 + sympy.sin(T) + 2
RECURRENCES = {
    "mul": (T + 2) * sympy.exp(T) * sympy.sin(T),
    "square": (sympy.exp(T) - T) ** 2,
    "cube": INNER**3,
    "seventh power": (1 + T / 4) ** 7 * sympy.exp(T),
    "multiples of an angle": sum(sympy.sin(n * INNER) * sympy.cos(n * T) for n in range(1, 8)),
    "many products": (sum(sympy.exp(T / n) ** n * sympy.cos(n * T**2 / 9) for n in range(1, 8)) - T)
    / INNER,
    "high power": (1 + sympy.sin(T) / 4) ** 11,
    "div": sympy.exp(T) / INNER,
    "reciprocal": 1 / INNER**2,
    "pow": INNER ** sympy.Rational(7, 3),
    "negative pow": INNER ** sympy.Rational(-3, 2),
    "sqrt": sympy.sqrt(INNER),
    "exp": sympy.exp(-(T**2)),
    "log": sympy.log(INNER),
    "sin": sympy.sin(INNER),
    "cos": sympy.cos(INNER),
    "sin and cos": sympy.sin(INNER) * sympy.cos(INNER),
    "tanh": sympy.tanh(INNER - 2),
    "asin": sympy.asin(sympy.sin(T / 2) * sympy.exp(T / 5)),
    "asin of a line": sympy.asin((T + 1) / 3),
    "nested": sympy.exp(-sympy.tanh(sympy.sqrt(INNER)) * sympy.log(INNER)),
}


@pytest.mark.parametrize("at", [0.0, 0.4, -0.3])
@pytest.mark.parametrize("name", RECURRENCES)
def test_recurrences(name: str, at: float) -> None:
    found, expected = series_of(RECURRENCES[name], at), expected_series(RECURRENCES[name], at)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-13 * scale)


def test_polynomials_end_at_their_degree() -> None:
    found = series_of((2 + T) ** 3 * T, 0.5)
    assert np.all(found[5:] == 0.0)
    np.testing.assert_allclose(found[:5], expected_series((2 + T) ** 3 * T, 0.5)[:5], rtol=1e-14)


# --- the graph -----------------------------------------------------------------------------------
LEAVES = ("a", "b", "x", "y")


@st.composite
def expressions(draw: Any, depth: int = 4) -> Any:
    """A random expression of two parameters and two states that is finite everywhere."""
    if depth == 0 or draw(st.integers(0, 3)) == 0:
        leaf = st.sampled_from([*map(sympy.Symbol, LEAVES), sympy.Integer(2), sympy.Rational(1, 3)])
        return draw(leaf)
    left = draw(expressions(depth=depth - 1))
    kind = draw(st.sampled_from(["+", "*", "/", "**", "sin", "exp", "tanh", "asin"]))
    if kind == "**":
        return left ** draw(st.integers(2, 5))
    if kind == "sin":
        return sympy.sin(left)
    if kind == "exp":
        return sympy.exp(sympy.sin(left))
    if kind == "tanh":
        return sympy.tanh(left)
    if kind == "asin":
        return sympy.asin(sympy.sin(left) / 2)
    right = draw(expressions(depth=depth - 1))
    if kind == "/":
        return left / (2 + sympy.cos(right))
    return left + right if kind == "+" else left * right


def leaves(graph: Graph) -> dict[Any, Node]:
    """Two parameters and two states by symbol."""
    a, b, x, y = (sympy.Symbol(name) for name in LEAVES)
    return {
        a: graph.parameter("a"), b: graph.parameter("b"),
        x: graph.state(0, "x"), y: graph.state(1, "y"),
    }  # fmt: skip


VALUES = {"a": 0.7, "b": -1.3, 0: 0.4, 1: 1.9}


def value_of(node: Node, seen: dict[int, float]) -> float:
    """Value of a node at `VALUES`, by its definition."""
    if node.index not in seen:
        inner = [value_of(arg, seen) for arg in node.args]
        seen[node.index] = _apply(node, inner, seen)
    return seen[node.index]


def _apply(node: Node, inner: list[float], seen: dict[int, float]) -> float:
    if node.op == "number":
        return float(node.value)
    if node.op in ("parameter", "state"):
        return VALUES[node.value]
    if node.op == "linear":
        constant, *weights = (value_of(weight, seen) for weight in node.value)
        return constant + sum(w * v for w, v in zip(weights, inner, strict=True))
    if node.op.removesuffix("_constant") in ("add", "mul", "div"):
        left, right = inner
        operations = {"add": left + right, "mul": left * right}
        short = node.op.removesuffix("_constant")
        return operations[short] if short in operations else left / right
    if node.op == "pow":
        return float(inner[0] ** node.value)
    return float(getattr(math, node.op)(inner[0]))


@given(expression=expressions())
def test_the_graph_has_the_value_of_the_expression(expression: Any) -> None:
    graph = Graph()
    node = graph.build(expression, leaves(graph))
    at = {sympy.Symbol(n): VALUES.get(n, VALUES.get(i - 2)) for i, n in enumerate(LEAVES)}
    expected = float(sympy.sympify(expression).subs(at).evalf(30))
    assert value_of(node, {}) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@given(expression=expressions())
def test_graph_invariants(expression: Any) -> None:
    graph = Graph()
    names = leaves(graph)
    node = graph.build(expression, names)
    count = len(graph.nodes)
    assert graph.build(expression, names) is node
    assert len(graph.nodes) == count
    keys = set()
    for place, each in enumerate(graph.nodes):
        assert each.index == place
        assert all(arg.index < each.index for arg in each.args)
        assert each.constant == (each.op != "state" and all(arg.constant for arg in each.args))
        value = tuple(v.index for v in each.value) if each.op == "linear" else each.value
        keys.add((each.op, tuple(arg.index for arg in each.args), value))
        if each.op == "linear":
            assert not any(arg.constant for arg in each.args)
            assert len({arg.index for arg in each.args}) == len(each.args)
            assert not any(w.op == "number" and w.value == 0.0 for w in each.value[1:])
    assert len(keys) == len(graph.nodes)


def test_sums_are_merged_where_that_costs_nothing_and_shared_where_it_would() -> None:
    graph = Graph()
    x, y, z = (graph.state(i, f"x{i}") for i in range(3))
    scale, three = graph.parameter("k"), graph.add(x, y, z)
    squares = [graph.mul(node, node) for node in (x, y, z)]
    (alone,) = graph.merged([graph.add(graph.mul(scale, three), squares[0])])
    assert set(alone.args) == {x, y, z, squares[0]}
    users = [graph.add(graph.mul(scale, three), square) for square in squares]
    assert all(three in user.args for user in graph.merged(users))
    kept, user = graph.merged([three, graph.add(three, squares[0])])
    assert kept is three and set(user.args) == {three, squares[0]}


def test_the_difference_of_what_moves_as_one_is_a_polynomial() -> None:
    graph = Graph()
    x, y, v = (graph.state(i, name) for i, name in enumerate("xyv"))
    apart, belt = graph.subtract(x, y), graph.add(v, graph.parameter("v0"))
    rates = [belt, v, graph.mul(v, v)]
    step = TaylorStep(graph, [x, y, v], rates, [graph.mul(apart, v)], 5, Coefficients())
    assert step.degrees[apart.index] == 1
    assert step.degrees[graph.mul(apart, v).index] > 5


def test_a_loop_over_orders_gives_what_each_order_by_itself_gives() -> None:
    graph = Graph()
    x, v = graph.state(0, "x"), graph.state(1, "v")
    waves = [graph.unary("sin", graph.mul(graph.number(n), x)) for n in range(1, 9)]
    series = []
    for loops in (True, False):
        step = TaylorStep(graph, [x, v], [v, graph.add(*waves)], [], ORDER, Coefficients())
        step.table = step.table if loops else None
        text = "\n".join(step.text("f", "series"))
        assert ("for k in" in text) == loops
        series.append(np.zeros(2 * ORDER + 2))
        python_functions(text)["f"](np.zeros(1), 0.0, np.array([0.3, 0.7]), series[-1])
    np.testing.assert_allclose(series[0], series[1], rtol=1e-12)


def test_what_turns_is_gathered_and_has_the_same_value() -> None:
    angle, rate, c, d, force, speed, drift = sympy.symbols("angle rate c d force speed drift")
    cosine, sine, turned = sympy.cos(2 * angle), sympy.sin(2 * angle), speed + drift * T
    shape = c * cosine + d * sine
    slope = sympy.diff(shape, angle)
    expression = turned**2 * shape + (rate - turned) * (rate * shape - 2 * turned * slope)
    expression += force * (cosine**2 + sine**2) + sympy.expand(force * slope * rate)
    found = gathered(expression, [angle, rate, c, d], [force], {speed: turned})
    assert sympy.expand(found - expression.subs(sine**2, 1 - cosine**2)) == 0
    assert not found.has(cosine**2, sine**2)


def test_an_expression_without_a_series_is_refused() -> None:
    graph = Graph()
    with pytest.raises(NotImplementedError, match="no series for"):
        graph.build(sympy.Abs(sympy.Symbol("x")), leaves(graph))
