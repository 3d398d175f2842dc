"""How far answers depend on the friction law, as ``fiv show`` says it."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic_datasets import response

from fiv_cli.reading import over_laws

LAWS = ["coulomb", "stribeck", "lugre"]


def test_classes_agree_and_numbers_differ_where_every_law_knows_them() -> None:
    classes = [
        ["periodic", "periodic", "chaotic"],
        ["periodic"] * 3,
        ["periodic", "undecided", "periodic"],
    ]
    L_s = np.array([[1.0, 4.0, 2.0], [3.0, 4.0, 2.0], [4.0, 4.0, np.nan]])
    dataset = response(classes, L_s, {"friction": LAWS, "mu_k": [0.1, 0.2, 0.3]})
    told = over_laws.spread(dataset)
    assert told["attractor"] == {"points": 2, "same": 1}
    assert told["L_s"] == {"points": 2, "median": pytest.approx(0.375), "greatest": 0.75}
    assert over_laws.spread(dataset.isel(friction=[0])) == {}
    assert over_laws.spread(dataset.isel(friction=0)) == {}
