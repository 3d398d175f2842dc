"""Starts in the dataset: where every motion began, whatever kind of start it had."""

from __future__ import annotations

import tomllib

import numpy as np

from fiv_cli import api

KINDS = """
schema = 1
[model]
name = "belt-1dof"
[model.parameters]
c = 0.05
[grid]
v = [2.0, 3.0]
[[initial]]
kind = "equilibrium"
offset = { x = 0.1 }
[[initial]]
kind = "state"
state = { x = 10.0, x_dot = "v" }
[[initial]]
kind = "random"
count = 3
box = { x = [4.0, 6.0], x_dot = [-1.0, 1.0] }
[[initial]]
label = "up"
kind = "continue"
along = "v"
from = "state"
[[analysis]]
kind = "response"
t_max = 200.0
[[analysis]]
kind = "eigenvalues"
"""


def test_the_state_that_a_motion_began_in_is_stored_for_every_kind_of_start() -> None:
    found = api.run(api.load(tomllib.loads(KINDS)), workers=1)["response"]
    begun = found["initial_state"].transpose("v", "initial", "state")
    at = {str(label): begun.sel(initial=label).values for label in found["initial"].values}
    rest = found["L_s_reference"].sel(initial="equilibrium", state="x").values
    np.testing.assert_allclose(at["equilibrium"], np.column_stack([rest + 0.1, [0.0, 0.0]]))
    assert at["state"].tolist() == [[10.0, 2.0], [10.0, 3.0]]
    drawn = np.array([at[f"random-{i:03d}"] for i in range(3)])
    assert (np.abs(drawn - [5.0, 0.0]) < 1.0).all() and len(np.unique(drawn[..., 0])) == 6
    assert at["up"][0].tolist() == at["state"][0].tolist()
    # a contact that sticks takes on the belt's new velocity
    ends = found.sel(initial="up", v=2.0)
    assert float(ends["x_min"]) <= at["up"][1][0] <= float(ends["x_max"])


SWEPT = """
schema = 1
[model]
name = "belt-1dof"
[model.parameters]
c = 0.1
[friction]
mu_s = 0.4
mu_k = 0.2
[grid]
v = { start = 0.5, stop = 5.0, num = 10 }
[[initial]]
label = "far"
kind = "state"
state = { x = 10.0 }
[[initial]]
label = "near"
kind = "equilibrium"
[[initial]]
label = "up"
kind = "continue"
along = "v"
from = "far"
on_loss = "go-on"
[[initial]]
label = "down"
kind = "continue"
along = "v"
direction = "down"
from = "near"
on_loss = "go-on"
[[analysis]]
kind = "response"
"""


def test_a_hysteresis_sweep_carries_the_motion_on_whatever_its_class() -> None:
    """Up, stick-slip is lost to rest; down, rest stays: every point as when begun there alone."""
    found = api.run(api.load(tomllib.loads(SWEPT)), workers=1)
    classes = api.names_of(found["attractor"])
    up, down = (classes.sel(initial=label).values.tolist() for label in ("up", "down"))
    assert set(down) == {"equilibrium"} and (found["status"] == 0).all()
    lost = up.index("equilibrium")
    assert up == ["periodic"] * lost + ["equilibrium"] * (len(up) - lost) and 0 < lost < len(up)
    begun = found["initial_state"].sel(initial="up")
    for point, told in zip(begun.transpose("v", "state"), up, strict=True):
        start, v = dict(zip(begun["state"].values, point.values, strict=True)), float(point["v"])
        alone = api.analyse(
            "belt-1dof", "coulomb", "response", start, v=v, c=0.1, mu_s=0.4, mu_k=0.2
        )
        assert alone.values["attractor"] == told
    rested = found["L_s_reference"].sel(initial="up", state="x").values[lost:-1]
    assert begun.sel(state="x").values[lost + 1 :].tolist() == rested.tolist()
