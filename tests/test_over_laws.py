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
        "differs": ["mu_k = 0.3"],
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
        "at": "mu_k = 0.1",
        "lowest": {"coulomb": 1, "stribeck": 0, "lugre": 0},
        "highest": {"coulomb": 0, "stribeck": 0, "lugre": 1},
    }
    said = over_laws.lines(told)
    assert said[1].endswith("the same at 1 of 2 points known under every law; not at mu_k = 0.3")
    assert said[2].endswith("  periodic 1, chaotic 1; alone at 1") and "coulomb" in said[2]
    assert said[5].endswith("most often lowest under coulomb (1), highest under lugre (1)")
    assert over_laws.spread(response(classes, np.ones((3, 3)), dict(dataset.coords))).keys() == {
        "attractor"
    }
    alike = response([["periodic"] * 3] * 3, np.ones((3, 3)), dict(dataset.coords))
    rounded = alike.assign(L_s=alike["L_s"] * (1.0 + 1e-15 * (alike["L_s"].mu_k > 0.1)))
    assert over_laws.lines(over_laws.spread(rounded))[-1] == over_laws.ALIKE
    assert over_laws.ALIKE not in said
    first = dataset.rename(L_s="critical_value").expand_dims(crossing=2, axis=-1)
    found = over_laws.spread(first.assign(status=dataset["status"]))
    assert found["critical_value"] == told["L_s"]
    ways = first["critical_value"].isnull().astype(np.int8)
    ways[{"friction": 0, "mu_k": 0, "crossing": 0}] = 1  # where the greatest spread was
    found = over_laws.spread(first.assign(status=dataset["status"], crossing_direction=ways))
    assert "critical_value" not in found  # at the other point all have the same
    assert over_laws.spread(dataset.isel(friction=[0])) == {}
    assert over_laws.spread(dataset.isel(friction=0)) == {}


def test_where_classes_differ_is_told_by_stretches() -> None:
    rows = {"near": "ppceepccpcpc", "far": "pppppppppppp"}
    names = {"p": "periodic", "c": "chaotic", "e": "equilibrium"}
    stribeck = np.array([[names[one] for one in row] for row in rows.values()])
    classes = np.stack([np.full(stribeck.shape, "periodic"), stribeck])
    grid = {"friction": LAWS[:2], "initial": [*rows], "Omega": np.arange(12.0)}
    told = over_laws.spread(response(classes, np.ones(classes.shape), grid))
    places = ["initial = near, Omega = 2 to 4"]
    places += [f"initial = near, Omega = {one}" for one in ("6 to 7", "9", "11")]
    assert told["attractor"]["differs"] == places and told["attractor"]["same"] == 17
    (_, line, *_) = over_laws.lines(told)
    assert line.endswith("; not at " + "; ".join(places))


def test_a_law_that_never_sticks_is_not_asked_how_long_it_does() -> None:
    grid = {"friction": LAWS, "mu_k": [0.1, 0.2]}
    share = ([*grid], np.array([[0.4, 0.2], [0.3, 0.2], [0.0, 0.0]]))
    ones = np.ones((3, 2))
    dataset = response(np.full((3, 2), "periodic"), ones, grid, stick_fraction=share)
    told = over_laws.spread(dataset)["stick_fraction"]
    assert told["greatest"] == pytest.approx(0.25) and told["lowest"] == {
        "coulomb": 0,
        "stribeck": 1,
    }
    assert over_laws.lines({"stick_fraction": told})[1].endswith("; not of lugre, without stick")
    assert "stick_fraction" not in over_laws.spread(dataset.isel(friction=[0, 2]))


def test_random_starts_are_others_under_each_law_and_are_not_compared() -> None:
    labels = ["rest", "far-000", "far-001"]
    classes = [["periodic", "periodic", "equilibrium"], ["periodic", "equilibrium", "periodic"]]
    dataset = response(classes, np.ones((2, 3)), {"friction": LAWS[:2], "initial": labels})
    assert over_laws.spread(dataset)["attractor"]["points"] == 3
    dataset.attrs["starts_json"] = '{"rest": "state", "far": "random"}'
    told = over_laws.spread(dataset)
    assert told["attractor"]["points"] == 1
    assert over_laws.WITHOUT_RANDOM in over_laws.lines(told)
    assert over_laws.spread(dataset.isel(initial=[1, 2])) == {}
