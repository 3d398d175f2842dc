"""What is no answer is told: balances without a number, claims on points without a class."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import synthetic_datasets as data
from small_models import TWO_MASSES

from fiv_cli import api
from fiv_cli.models.base import Equations, Options
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, UNDETERMINED


# --- a balance without a number ------------------------------------------------------------------
def _mistaken(symbols: Any, options: Options) -> Equations:
    """Two masses, and an energy that is the root of a negative number where they are."""
    found = TWO_MASSES.equations(symbols, options)
    root = (symbols.coordinate("x1") - 1000) ** 0.5
    return replace(found, potential_energy=found.potential_energy + root)


MISTAKEN = replace(TWO_MASSES, name="mistaken", equations=_mistaken)


@pytest.mark.parametrize(("kind", "settings"), [("response", {}), ("history", {"t_end": 9.0})])
def test_energies_that_are_no_number_fail_the_point(kind: str, settings: Any) -> None:
    found = api.analyse(MISTAKEN, "coulomb", kind, {"x1": 0.3}, settings, N2=8.0)
    assert (found.status, found.reason, found.values) == ("failed", "no_number", {})


# --- claims on points without a class -----------------------------------------------------------
@pytest.mark.parametrize(
    ("expect", "verdict"),
    [
        ({"greater_than": 0.5}, UNDETERMINED),
        ({"less_than": 0.5}, UNDETERMINED),
        ({"value": 0.8, "tolerance": 0.05}, UNDETERMINED),
        ({"greater_than": 0.19}, CONFIRMED),
        ({"less_than": 0.96}, CONFIRMED),
        ({"greater_than": 0.96}, CONTRADICTED),
    ],
)
def test_a_share_is_known_as_far_as_the_decided_points_say(expect: Any, verdict: str) -> None:
    """Of 200 points 40 are periodic, 10 are not, 150 may be either: a share of 0.2 to 0.95."""
    classes = np.repeat(["periodic", "equilibrium", "undecided"], [40, 10, 150]).astype(object)
    points = data.response(classes, np.ones(200), data.axes(Omega=np.arange(200.0)))
    share = {"what": "share", "of": "periodic", "over": ["Omega"]}
    assert data.tried(points, "attractor", expect, take=share).verdict == verdict
