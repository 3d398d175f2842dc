"""Elements in parallel that stick and slip, each for itself: generalised Maxwell slip.

    F_T = (sum f_i + sigma_2 v) N
    df_i/dt = k_i v                        while |f_i| < alpha_i s(v)    the element holds
    df_i/dt = +-C (alpha_i -+ f_i/s(v))    until v turns                 it slides, as +-v > 0

with s = mu_k + (mu_s - mu_k) exp(-(v/v_s)^2) and the alpha_i together 1; f_i, k_i and s are per
unit of normal force, as in LuGre's law. In steady sliding F_T = (s + sigma_2 v) N. C, 1/s, is how
fast a force follows Stribeck's curve: friction lags. With mu_s = mu_k, C does not enter and each
element is a spring with a Coulomb slider: of n such in parallel (Iwan) the loops of slip about a
turn are similar to the first loading curve (Masing), and the cycle under a slip of amplitude A
encloses 4 N sum alpha_i mu_k (A - alpha_i mu_k/k_i) over those with a positive bracket. Elements
that are alike are one: four equal ones a Jenkins element. Lampaert, Al-Bender & Swevers, Physcon
2003, St Petersburg; it takes the place of the Leuven model (Swevers et al., IEEE Trans. Automatic
Control 45 (2000) 675), whose memory is a stack.

It does not stick, and while the contact is open the forces stay as they were.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fiv_cli.friction.base import Exit, Law, Piece, Slip
from fiv_cli.friction.coulomb import FALLING, MU_S
from fiv_cli.friction.dahl import POSITIVE_MU_K
from fiv_cli.friction.jenkins import BACKWARD, FORWARD, HOLDS, steadily
from fiv_cli.friction.lugre import SIGMA_2
from fiv_cli.friction.stribeck import V_S
from fiv_cli.models.base import Parameter, Requirement, State

if TYPE_CHECKING:
    from sympy import Expr

ELEMENTS = range(1, 5)
# As those of `jenkins.SLIDER`, but an element leaves its limit as Stribeck's curve rises or falls.
PIECES = (
    Piece(HOLDS, (0.0,), (Exit(FORWARD, (0, 0)), Exit(BACKWARD, (0, 0)))),
    Piece(FORWARD, (1.0,), (Exit(HOLDS, (0, 0)), None)),
    Piece(BACKWARD, (-1.0,), (Exit(HOLDS, (0, 0)), None)),
)
SHARES = tuple(f"alpha_{i}" for i in ELEMENTS)


def _curve(slip: Slip, p: Mapping[str, Expr]) -> Expr:
    """s(v)."""
    import sympy

    return p["mu_k"] + (p["mu_s"] - p["mu_k"]) * sympy.exp(-((slip.v / p["v_s"]) ** 2))


def rates(slip: Slip, p: Mapping[str, Expr]) -> Mapping[str, Expr]:
    """Rates of the forces of the elements, per normal force, 1/s."""
    found, curve = {}, _curve(slip, p)
    for i, (way,) in zip(ELEMENTS, slip.rows, strict=True):
        lag = way * p[f"alpha_{i}"] - slip.states[f"f_{i}"] / curve
        found[f"f_{i}"] = (1 - way**2) * p[f"k_{i}"] * slip.v + way**2 * p["C_lag"] * lag
    return found


def guards(slip: Slip, p: Mapping[str, Expr]) -> Sequence[Sequence[Expr]]:
    """What is positive while each element holds, or slides.

    It begins to slide the way that the contact slips, as its force is at the limit on that side;
    as slip turns all of them hold.
    """
    forward, curve, found = (1 + slip.sign) / 2, _curve(slip, p), []
    for i, (way,) in zip(ELEMENTS, slip.rows, strict=True):
        share = slip.states[f"f_{i}"] / (p[f"alpha_{i}"] * curve)
        upper = (1 - way**2) * (1 - forward * share) + way * slip.sign
        lower = (1 - way**2) * (1 + (1 - forward) * share) + way**2
        found.append((upper, lower))
    return found


def _of_element(i: int) -> tuple[Parameter, Parameter]:
    return (
        Parameter(
            f"alpha_{i}", rf"\alpha_{i}", "1", i / 10, f"share of friction, element {i}", "",
            0.0, 1.0, exclusive=True,
        ),
        Parameter(
            f"k_{i}", f"k_{i}", "m-1", 250.0, f"stiffness per normal force, element {i}", "",
            0.0, exclusive=True,
        ),
    )  # fmt: skip


LAW = Law(
    name="gms",
    title="four elements in parallel that stick and slip (generalised Maxwell slip)",
    reference="Lampaert, Al-Bender & Swevers, Physcon 2003; Iwan, J. Appl. Mech. 33 (1966) 893",
    numerics_version=1,
    parameters=(
        MU_S,
        POSITIVE_MU_K,
        V_S,
        *(parameter for i in ELEMENTS for parameter in _of_element(i)),
        Parameter(
            "C_lag", "C", "s-1", 10.0, "rate at which sliding follows its curve", "", 0.0,
            exclusive=True,
        ),
        SIGMA_2,
    ),
    force=lambda slip, p: (sum(slip.states.values()) + p["sigma_2"] * slip.v) * slip.N,
    capacity=None,
    states=tuple(State(f"f_{i}", f"f_{i}", "1", f"force of element {i}") for i in ELEMENTS),
    rates=rates,
    requirements=(
        FALLING,
        Requirement(
            SHARES,
            lambda p: abs(sum(p[name] for name in SHARES) - 1.0) < 1e-9,
            "alpha_1 + alpha_2 + alpha_3 + alpha_4 = 1",
            "the shares alpha_1 ... alpha_4 do not make up 1",
            "no_number",
        ),
    ),
    steady=lambda slip, p: (slip.sign * _curve(slip, p) + p["sigma_2"] * slip.v) * slip.N,
    stored=lambda slip, p: (
        sum(slip.states[f"f_{i}"] ** 2 / p[f"k_{i}"] for i in ELEMENTS) * slip.N / 2
    ),
    pieces=PIECES,
    elements=len(ELEMENTS),
    guards=guards,
    resting=lambda v, p: [steadily(v)] * len(ELEMENTS),
)  # fmt: skip
