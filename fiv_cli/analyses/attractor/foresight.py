"""Where a branch of steady motions leads, by the last two of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fiv_cli.analyses.attractor.bisection import Look

REPEATING = ("periodic", "equilibrium")  # classes of motions that leave the same state again


def foreseen(earlier: Look, last: Look, value: float) -> Look | None:
    """The last look with the state that a straight line through both has at `value`.

    None where they left no states to draw it through: of rest, or of cycles, in one contact state.
    """
    one, other = earlier.carry, last.carry
    if one is None or one.get("attractor") not in REPEATING or earlier.value == last.value:
        return None
    if any(one[name] != other[name] for name in ("attractor", "sticking")):
        return None
    before, state = np.array(one["state"]), np.array(other["state"])
    share = (value - last.value) / (last.value - earlier.value)
    return replace(last, carry={**other, "state": (state + share * (state - before)).tolist()})
