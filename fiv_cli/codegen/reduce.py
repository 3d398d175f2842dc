"""Derives the reduction of `statics.py` with exact algebra."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, zip_longest

import sympy
from sympy import Expr
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError

from fiv_cli.codegen.eliminate import without_modes
from fiv_cli.codegen.emit import constants
from fiv_cli.codegen.graph import Graph, Node
from fiv_cli.codegen.reduction import ELIMINATED, FUNCTION, Reduction, Slots, Statics
from fiv_cli.codegen.setup import Setup
from fiv_cli.friction.base import Slip
from fiv_cli.models.base import Contact, Equations
from fiv_cli.models.symbols import Symbols

MOST_REDUCTIONS = 3
LONG_SUM = 4  # terms; sums over the thesis' seven modes, four frequencies, are not longer


def derive_statics(setup: Setup) -> Statics:
    """What is known of a system at rest, every contact closed and slipping, stops open."""
    symbols = Symbols(setup.structural)
    contacts = setup.model.equations(symbols, setup.options).contacts
    rest = _at_rest(setup, symbols)
    return Statics(
        bilateral=tuple(map(_is_bilateral, contacts)),
        determined=tuple(
            c.gap_coordinate for c in contacts if c.gap_coordinate is not None and not c.is_stop
        ),
        reductions=() if rest is None else tuple(islice(_reductions(rest), MOST_REDUCTIONS)),
    )


def _is_bilateral(contact: Contact) -> bool:
    """Whether nothing happens to the contact where its normal force changes sign."""
    return contact.is_stop or (contact.gap is None and not contact.ends_at_zero_normal_force)


@dataclass
class _Rest:
    """The equations at rest, as polynomials in the unknowns.

    Attributes
    ----------
    unknowns : normal forces, then coordinates
    equations : expressions that vanish: of each contact, then of each coordinate
    eliminated : coordinates that are none of the unknowns any more -> their values
    parameters : symbol of each parameter -> its name
    names : of the parameters, in order
    atoms : functions of parameters alone -> the symbol that stands for each
    """

    unknowns: list[Expr]
    equations: list[Expr]
    eliminated: dict[Expr, Expr]
    parameters: dict[Expr, str]
    names: tuple[str, ...]
    atoms: dict[Expr, Expr] = field(default_factory=dict)

    def with_atoms(self, expression: Expr) -> Expr:
        """`expression` with every function of parameters alone replaced by a symbol."""
        whole = not expression.is_Pow or expression.exp.is_Integer
        known = not expression.free_symbols & set(self.unknowns)
        if known and (expression.is_Function or not whole):
            return self.atoms.setdefault(expression, sympy.Dummy(real=True))
        if not expression.args:
            return expression
        return expression.func(*map(self.with_atoms, expression.args))


def _at_rest(setup: Setup, symbols: Symbols) -> _Rest | None:
    """The equations at rest; None where they are not polynomial in the unknowns."""
    equations = setup.model.equations(symbols, setup.options)
    names = [state.name for state in setup.model.states(setup.options)]
    count = len(equations.contacts)
    unknowns = [symbols.normal_force(i) for i in range(count)]
    unknowns += [symbols.coordinate(name) for name in names]
    still = {symbols.velocity(name): 0 for name in names} | {symbols.time: 0}
    still |= {symbols.closed(i): int(not c.is_stop) for i, c in enumerate(equations.contacts)}
    friction = _friction(symbols, setup, equations)
    coefficients: dict[Expr, Expr] = {}
    forces = {
        symbol: _shortened(force.subs(still), unknowns, coefficients)
        for symbol, force in friction.items()
    }
    vanishing = [_contact(symbols, contact, i) for i, contact in enumerate(equations.contacts)]
    vanishing += [equations.accelerations[name] for name in names]
    exact = [sympy.sympify(e).subs(forces).subs(still) for e in vanishing]
    parameters = _parameters(setup, symbols, equations.contacts)
    laid_out = dict(zip(unknowns, exact, strict=True))
    return _polynomial(laid_out, unknowns[count:], parameters, coefficients)


def _shortened(force: Expr, unknowns: Sequence[Expr], atoms: dict[Expr, Expr]) -> Expr:
    """A friction force with its coefficient, where it is a function of parameters, one symbol."""
    coefficient, rest = force.as_independent(*unknowns, as_Add=False)
    if not coefficient.has(sympy.Function, sympy.exp):
        return force
    return atoms.setdefault(coefficient, sympy.Dummy(real=True)) * rest


def _parameters(setup: Setup, symbols: Symbols, contacts: Sequence[Contact]) -> dict[Expr, str]:
    """Symbol -> name of every parameter, number of a piece, sign of slip, and of the zone."""
    found = {sympy.Symbol(f"p.{name}", real=True): name for name in setup.parameter_names}
    shapes = [setup.law_of(contact).shape for contact in contacts]
    rows = [row for i, shape in enumerate(shapes) for row in symbols.rows(i, *shape)]
    found |= {symbol: symbol.name for row in rows for symbol in row}
    found |= {symbols.sign(i): f"sign.{i}" for i in range(len(contacts))}
    return found | {symbols.zone: "zone"}


def _polynomial(
    vanishing: Mapping[Expr, Expr],
    coordinates: Sequence[Expr],
    parameters: dict[Expr, str],
    atoms: dict[Expr, Expr],
) -> _Rest | None:
    """What vanishes, as polynomials; None where that is impossible."""
    left = without_modes(vanishing, coordinates)
    if left is None:
        return None
    unknowns = list(left.expressions)
    rest = _Rest(unknowns, [], left.values, parameters, tuple(parameters.values()), atoms)
    for expression in left.expressions.values():
        numerator = _numerator(rest, _lumped(expression, unknowns, atoms))
        if not numerator.is_polynomial(*unknowns):
            return None
        rest.equations.append(numerator)
    return rest


def _lumped(expression: Expr, unknowns: Sequence[Expr], atoms: dict[Expr, Expr]) -> Expr:
    """`expression` with one symbol for each long sum that multiplies the same unknowns.

    Sums over many modes would have a common denominator of as many factors.
    """
    if not expression.args or not expression.has(*unknowns):
        return expression
    inner = expression.func(*(_lumped(one, unknowns, atoms) for one in expression.args))
    if not inner.is_Add:
        return inner
    groups: dict[Expr, list[Expr]] = {}
    for term in inner.args:
        factor, monomial = term.as_independent(*unknowns, as_Add=False)
        groups.setdefault(monomial, []).append(factor)
    terms = []
    for monomial, factors in groups.items():
        total = sympy.Add(*factors)
        if len(factors) > LONG_SUM:
            total = atoms.setdefault(total, sympy.Dummy(real=True))
            factors = [total]
        terms += [factor * monomial for factor in factors]
    return sympy.Add(*terms)


def _friction(symbols: Symbols, setup: Setup, equations: Equations) -> dict[Expr, Expr]:
    """Symbol of each friction force -> what the law makes of it."""
    found = {}
    for i, contact in enumerate(equations.contacts):
        law = setup.law_of(contact)
        given = equations.law_parameters_at(i, law.parameters, symbols)
        sign, v = symbols.sign(i), contact.slip_velocity
        slip = Slip(v, sign, sign * v, symbols.normal_force(i), rows=symbols.rows(i, *law.shape))
        found[symbols.tangential_force(i)] = sympy.sympify(law.sliding(slip, given))
    return found


def _contact(symbols: Symbols, contact: Contact, index: int) -> Expr:
    """Vanishes at rest: the gap of a rigid contact, the force balance of a soft one or a stop."""
    if contact.is_stop:
        return symbols.normal_force(index)
    if contact.normal_force is None:
        return contact.gap
    return symbols.normal_force(index) - contact.normal_force


def _numerator(rest: _Rest, expression: Expr) -> Expr:
    exact = sympy.nsimplify(expression, rational=True)
    return sympy.fraction(sympy.together(rest.with_atoms(exact)))[0]


# --- the choice of the scalar ---------------------------------------------------------------------
def _reductions(rest: _Rest) -> Iterator[Reduction]:
    """A reduction by each unknown that leaves the others linear."""
    done = set()
    for scalar, closure in _candidates(rest):
        if scalar not in done:
            others = [u for u in rest.unknowns if u != scalar]
            linear = [e for i, e in enumerate(rest.equations) if i != closure]
            solved = _solve(linear, others, scalar)
            if solved is not None:
                done.add(scalar)
                yield _written(rest, scalar, others, solved, rest.equations[closure])


def _candidates(rest: _Rest) -> Iterator[tuple[Expr, int]]:
    """(scalar, number of the closure) with every other equation linear in the other unknowns."""
    for place, scalar in enumerate(rest.unknowns):
        others = [u for u in rest.unknowns if u != scalar]
        curved = [i for i, e in enumerate(rest.equations) if _degree(e, others) > 1]
        if len(curved) == 1:
            yield scalar, curved[0]
        if not curved:
            yield scalar, place
            yield from ((scalar, i) for i in range(len(rest.equations)) if i != place)


def _degree(expression: Expr, unknowns: Sequence[Expr]) -> int:
    """Total degree in `unknowns` as the expression is written (not multiplied out)."""
    if expression in unknowns:
        return 1
    if not expression.free_symbols & set(unknowns):
        return 0
    if expression.is_Pow:
        return int(expression.exp) * _degree(expression.base, unknowns)
    degrees = [_degree(argument, unknowns) for argument in expression.args]
    return max(degrees) if expression.is_Add else sum(degrees)


def _solve(equations: Sequence[Expr], unknowns: Sequence[Expr], scalar: Expr) -> list[Expr] | None:
    """Numerators of `unknowns` and, last, their denominator, as polynomials in `scalar`.

    None where the equations do not determine the unknowns.
    """
    if not unknowns:
        return [sympy.Poly(1, scalar)]
    matrix, right = sympy.linear_eq_to_matrix(equations, unknowns)
    left = DomainMatrix.from_Matrix(matrix)
    left, column = left.unify(DomainMatrix.from_Matrix(right), fmt="dense")
    try:
        numerators, denominator = left.solve_den(column)
    except DMNonInvertibleMatrixError:
        return None
    field_ = numerators.domain
    found = [*numerators.to_Matrix(), field_.to_sympy(denominator)]
    common = sympy.gcd_list([sympy.expand(one) for one in found])
    return [sympy.Poly(sympy.cancel(one / common), scalar) for one in found]


# --- the generated function -----------------------------------------------------------------------
def _written(
    rest: _Rest, scalar: Expr, others: Sequence[Expr], solved: Sequence[Expr], closure: Expr
) -> Reduction:
    writer = _Writer(rest)
    polynomials = [writer.polynomial(one) for one in solved]
    inserted = _Inserted(writer, scalar, dict(zip(others, polynomials, strict=False)), polynomials)
    *numerators, denominator = [writer.slots(one) for one in polynomials]
    return Reduction(
        parameters=rest.names,
        scalar=_name(scalar),
        unknowns=tuple(map(_name, others)),
        numerators=tuple(numerators),
        denominator=denominator,
        closure=writer.slots(inserted.value(closure).above),
        n_slots=len(writer.nodes),
        eliminated=tuple(map(_name, rest.eliminated)),
        text=writer.text([scalar, *others]),
    )


def _name(symbol: Expr) -> str:
    """``x1`` of the symbol ``q.x1``, ``F_N.0`` of ``F_N.0``."""
    return str(symbol.name).removeprefix("q.")


Polynomial = list[Node]  # coefficients from s^0 upwards


class _Writer:
    """Collects coefficients, each in a slot, and writes the function that computes them."""

    def __init__(self, rest: _Rest) -> None:
        self.rest = rest
        self.graph = Graph()
        self.nodes: list[Node] = []
        names = {symbol: self.graph.parameter(name) for symbol, name in rest.parameters.items()}
        for made, symbol in rest.atoms.items():  # later ones may contain earlier ones
            names[symbol] = self.graph.build(made, names)
        self.leaves = names

    def polynomial(self, found: Expr) -> Polynomial:
        """Nodes of the coefficients of a SymPy polynomial."""
        return [self.graph.build(one, self.leaves) for one in reversed(found.all_coeffs())]

    def slots(self, polynomial: Polynomial) -> Slots:
        """A slot for each coefficient."""
        first = len(self.nodes)
        self.nodes += polynomial
        return tuple(range(first, len(self.nodes)))

    def text(self, solved: Sequence[Expr]) -> str:
        """The function of parameters alone, and that of what is `solved` beside them."""
        lines = constants(FUNCTION, self.nodes, self.rest.names)
        inner = {symbol: self.graph.parameter(_name(symbol)) for symbol in solved}
        values = self.rest.eliminated.values()
        nodes = [self.graph.build(value, self.leaves | inner) for value in values]
        if nodes:
            lines += constants(ELIMINATED, nodes, (*self.rest.names, *map(_name, solved)))
        return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class _Quotient:
    """``above / denominator^power``."""

    above: Polynomial
    power: int


class _Inserted:
    """The closure with the linear unknowns inserted: a polynomial over a power of their
    denominator, worked out in the order in which the closure is written."""

    def __init__(
        self,
        writer: _Writer,
        scalar: Expr,
        numerators: Mapping[Expr, Polynomial],
        solved: Sequence[Polynomial],
    ) -> None:
        self.graph = writer.graph
        self.leaves = writer.leaves
        self.denominator = solved[-1]
        self.known = {unknown: _Quotient(above, 1) for unknown, above in numerators.items()}
        self.known[scalar] = _Quotient([self.graph.zero, self.graph.one], 0)

    def value(self, expression: Expr) -> _Quotient:
        """`expression` as a quotient."""
        if expression in self.known:
            return self.known[expression]
        if not expression.free_symbols & set(self.known):
            return _Quotient([self.graph.build(expression, self.leaves)], 0)
        if expression.is_Pow:
            return self._product([self.value(expression.base)] * int(expression.exp))
        inner = [self.value(argument) for argument in expression.args]
        return self._sum(inner) if expression.is_Add else self._product(inner)

    def _product(self, factors: Sequence[_Quotient]) -> _Quotient:
        above = [self.graph.one]
        for factor in factors:
            above = self._times(above, factor.above)
        return _Quotient(above, sum(factor.power for factor in factors))

    def _sum(self, terms: Sequence[_Quotient]) -> _Quotient:
        power = max(term.power for term in terms)
        total: Polynomial = []
        for term in terms:
            above = term.above
            for _ in range(power - term.power):
                above = self._times(above, self.denominator)
            total = self._plus(total, above)
        return _Quotient(total, power)

    def _times(self, left: Polynomial, right: Polynomial) -> Polynomial:
        product = [self.graph.zero] * (len(left) + len(right) - 1)
        for i, a in enumerate(left):
            for j, b in enumerate(right):
                product[i + j] = self.graph.add(product[i + j], self.graph.mul(a, b))
        return product

    def _plus(self, left: Polynomial, right: Polynomial) -> Polynomial:
        pairs = zip_longest(left, right, fillvalue=self.graph.zero)
        return [self.graph.add(a, b) for a, b in pairs]
