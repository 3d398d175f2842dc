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
    assert told["attractor"] == {
        "points": 2,
        "same": 1,
        "counts": {
            "coulomb": {"periodic": 1, "chaotic": 1},
            "stribeck": {"periodic": 2},
            "lugre": {"periodic": 2},
        },
        "alone": {"coulomb": 1, "stribeck": 0, "lugre": 0},
    }
    assert told["L_s"] == {
        "points": 2,
        "median": pytest.approx(0.375),
        "greatest": 0.75,
        "lowest": {"coulomb": 1, "stribeck": 0, "lugre": 0},
        "highest": {"coulomb": 0, "stribeck": 0, "lugre": 1},
    }
    said = over_laws.lines(told)
    assert "the same at 1 of 2 points known under every law" in said[1]
    assert said[2].endswith("  periodic 1, chaotic 1; alone at 1") and "coulomb" in said[2]
    assert said[5].endswith("most often lowest under coulomb (1), highest under lugre (1)")
    assert over_laws.spread(response(classes, np.ones((3, 3)), dict(dataset.coords))).keys() == {
        "attractor"
    }
    assert over_laws.spread(dataset.isel(friction=[0])) == {}
    assert over_laws.spread(dataset.isel(friction=0)) == {}
