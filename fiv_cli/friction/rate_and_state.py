"""Friction that depends on the slip speed and on the age of the contact (rate and state).

    F_T = a arsinh(v/(2 v_0) exp((mu_0 + b ln(v_0 theta/D_c))/a)) N
    d(theta)/dt = 1 - |v| theta/D_c

theta, s, is the mean age of the asperities in contact, D_c the slip that renews them: the ageing
law of Dieterich, J. Geophysical Research 84 (1979) 2161, and Ruina, ibid. 88 (1983) 10359, of
which (mu_0 + a ln(v/v_0) + b ln(v_0 theta/D_c)) N is the common form. That has no v = 0; the
arsinh (Rice & Ben-Zion, PNAS 93 (1996) 3811) differs from it by exp(-2 mu/a) and is odd in v. The
state is v_0 theta/D_c - 1: a contact begins at zero, as after steady slip at v_0.

In steady sliding F_T = (mu_0 + (a - b) ln(|v|/v_0)) N. With b > a a body on a spring slides
unsteadily where its stiffness is below (b - a) N/D_c (1 + m v^2/(a N D_c)).

It never sticks: it creeps, at speeds below v_0 by powers of ten. There the force is stiff, with a
rate of a N/(m |v|). About v = 0 it turns from one sense to the other within v_0 exp(-mu_0/a), which
no step resolves: the law is for slip that goes on one way. A motion whose slip turns round ends in
`no_number`, or runs out of steps; `rate-and-state-cutoff` can turn.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Law, Slip
from fiv_cli.models.base import Parameter, Requirement, State

if TYPE_CHECKING:
    from sympy import Expr

STEEPEST = 300.0  # mu_0/a: the square of exp(mu_0/a) is a number up to 354
AGE = State("age", r"v_0 \theta/D_c - 1", "1", "age of the contact over D_c/v_0, less 1")


def force(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """F_T in N."""
    import sympy

    aged = p["b_state"] * sympy.log(1 + slip.states["age"])
    level = sympy.exp((p["mu_0"] + aged) / p["a_rate"])
    argument = slip.speed / (2 * p["v_0"]) * level
    arsinh = sympy.log(argument + sympy.sqrt(argument**2 + 1))
    return slip.sign * p["a_rate"] * arsinh * slip.N


def rates(slip: Slip, p: Mapping[str, Expr]) -> Mapping[str, Expr]:
    """d(v_0 theta/D_c)/dt in 1/s."""
    return {"age": (p["v_0"] - slip.speed * (1 + slip.states["age"])) / p["D_c"]}


def _positive(name: str, symbol: str, unit: str, default: float, meaning: str) -> Parameter:
    return Parameter(name, symbol, unit, default, meaning, "", 0.0, exclusive=True)


LAW = Law(
    name="rate-and-state",
    title="friction that depends on the slip speed and the age of the contact",
    reference="Dieterich, J. Geophys. Res. 84 (1979) 2161; Ruina, ibid. 88 (1983) 10359",
    numerics_version=1,
    parameters=(
        _positive("mu_0", r"\mu_0", "1", 0.6, "coefficient of friction in steady slip at v_0"),
        _positive("a_rate", "a", "1", 0.01, "direct effect of the slip speed"),
        Parameter("b_state", "b", "1", 0.015, "effect of the age of the contact", "", 0.0),
        _positive("D_c", r"D_\mathrm{c}", "m", 1e-3, "slip that renews the contact"),
        _positive("v_0", "v_0", "m s-1", 1e-2, "reference slip speed"),
    ),
    force=force,
    capacity=None,
    states=(AGE,),
    rates=rates,
    requirements=(
        Requirement(
            ("mu_0", "a_rate"),
            lambda p: p["mu_0"] <= STEEPEST * p["a_rate"],
            f"mu_0/a_rate <= {STEEPEST:g}",
            "a_rate is so small that exp(mu_0/a_rate) is no number",
            "no_number",
        ),
    ),
)
