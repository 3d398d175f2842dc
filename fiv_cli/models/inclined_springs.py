"""What the two models with inclined springs share (thesis Figures 3.11 and 5.1).

A point mass on a belt, held by two springs at the angles alpha_1 and alpha_2 to the belt and by
the contact stiffness k3. The normal force is F_N = -k3 y (3.24, 5.4).

Where the mass may leave the belt (``states = all``), it comes back in one of two ways:

- ``impact = plastic``: y' is zero after re-contact, as the thesis has it in chapters 4, 6 and 7;
  m y'^2/2 is lost.
- ``impact = none``: k3 is a spring that only pushes. It is unloaded at re-contact, F_N = 0, so that
  y' goes on as it is and nothing is lost.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fiv_cli.models.base import Contact, Option, Options, State

if TYPE_CHECKING:
    from sympy import Expr

    from fiv_cli.models.symbols import Symbols

UNTIL_SEPARATION, SLIP, ALL = "until-separation", "slip", "all"

STATES = (
    State("x", "x", "m", "displacement along the belt"),
    State("y", "y", "m", "displacement away from the belt"),
)

OPTIONS = (
    Option(
        "states",
        (UNTIL_SEPARATION, SLIP, ALL),
        UNTIL_SEPARATION,
        "what happens at zero normal force: the run ends; nothing, for contact is bilateral and "
        "the mass only slides; the mass leaves the belt and comes back",
    ),
    Option(
        "impact",
        ("plastic", "none"),
        "plastic",
        "re-contact under states = all: y_dot is zero after it, or goes on as it is, k3 being a "
        "spring that only pushes",
        later=True,
    ),
)


def inclined(alpha_1: Expr, alpha_2: Expr, first: Expr, second: Expr) -> tuple[Expr, Expr, Expr]:
    """(11, 12, 22) of a matrix made by two elements at the angles alpha_1 and -alpha_2.

    Thesis 3.23 (without k3) and 5.2.
    """
    from sympy import cos, sin

    return (
        first * cos(alpha_1) ** 2 + second * cos(alpha_2) ** 2,
        -first * sin(alpha_1) * cos(alpha_1) + second * sin(alpha_2) * cos(alpha_2),
        first * sin(alpha_1) ** 2 + second * sin(alpha_2) ** 2,
    )


def contact(symbols: Symbols, options: Options) -> Contact:
    """The contact with the belt under the options."""
    chosen = options["states"]
    y = symbols.coordinate("y")
    return Contact(
        slip_velocity=symbols.parameter("v") - symbols.velocity("x"),
        slip_coordinate="x",
        normal_force=-symbols.parameter("k3") * y,
        gap=y if chosen == ALL else None,
        ends_at_zero_normal_force=chosen == UNTIL_SEPARATION,
        impact=options["impact"],
        sliding_only=chosen == SLIP,
    )
