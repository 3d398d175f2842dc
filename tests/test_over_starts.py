"""Where what is reached depends on the start: told by `fiv show`, claimed, and drawn."""

from __future__ import annotations

from math import atan, atan2, cos, exp, hypot, pi, sqrt

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from scipy.optimize import brentq
from synthetic_datasets import tried

from fiv_cli import api
from fiv_cli.case.load import parse_case
from fiv_cli.reading import over_starts, shares
from fiv_cli.reading.claims import CONFIRMED, CONTRADICTED, UNDETERMINED
from fiv_cli.reading.datasets import is_class
from fiv_cli.reading.over_laws import stretches

DAMPING = 0.2
HELD = {"here": 0.1, "there": -0.2}  # m, of either the spring pulls less than friction holds
NAMES = {"e": "equilibrium", "p": "periodic", "c": "chaotic", "u": "undecided"}
BELT = f"""\
schema = 1
[model]
name = "belt-1dof"
parameters = {{ c = {DAMPING} }}
[grid]
v = {{ start = 0.25, stop = 6.0, step = 0.25 }}
[[initial]]
label = "rest"
kind = "equilibrium"
[[initial]]
label = "stuck"
kind = "state"
state = {{ x = 2.0, x_dot = "v" }}
[[analysis]]
kind = "response"
t_max = 200.0
"""


def miss(speed: float) -> float:
    """By how much the mass, let go by the belt, misses its speed at the end of the slip."""
    rate = sqrt(1.0 - DAMPING**2 / 4)
    drop = (0.4 - 0.23) * 10.0  # of the force as slip begins; m = k = 1
    falling = (DAMPING * speed / 2 - drop) / rate
    lag = atan(DAMPING / 2 / rate)
    when = (atan2(falling, speed) - lag + 2 * pi) / rate
    return hypot(speed, falling) * cos(lag) * exp(-DAMPING * when / 2) - speed


def test_the_end_of_stick_slip_and_the_bistable_range_are_those_of_the_closed_form() -> None:
    border = brentq(miss, 0.01, 20.0)
    found = api.run(parse_case(BELT, "belt.toml"))
    speeds = found["v"].values
    last = float(speeds[speeds < border][-1])
    assert 0.25 < last < 6.0
    (told,) = over_starts.differing(found)
    assert (told["differ"], told["points"]) == ((speeds < border).sum(), speeds.size)
    assert told["at"] == [f"v = 0.25 to {last:g} m s-1"]
    assert told["classes"] == {"equilibrium against periodic": told["differ"]}
    take = {"what": "last", "of": "periodic", "over": ["v"]}
    for between, verdict in (
        ([last, last + 0.25], CONFIRMED),
        ([last, border], UNDETERMINED),
        ([last + 0.25, 6.0], CONTRADICTED),
    ):
        expect = {"between": between}
        assert tried(found, "attractor", expect, {"initial": "stuck"}, take=take).verdict == verdict
    take = {"what": "classes", "over": ["initial"]}
    for side, count in ((f". < {border}", 2), (f". > {border}", 1)):
        expect = {"value": count, "tolerance": 0.0}
        assert tried(found, "attractor", expect, {"v": side}, take=take).verdict == CONFIRMED


def reached(rows: dict[str, str], L_s: object = 1.0, **axes: object) -> dict[str, object]:
    """What is said of starts and the classes that each reaches, point by point (C order)."""
    axes = axes or {"mu_k": np.arange(max(map(len, rows.values())))}
    grid = data.axes(initial=[*rows], **axes)
    shape = tuple(len(values) for _, values, _ in grid.values())
    classes = np.array([[NAMES[one] for one in row] for row in rows.values()]).reshape(shape)
    numbers = np.broadcast_to(L_s, (len(rows), np.size(classes) // len(rows))).reshape(shape)
    return over_starts.differing(data.response(classes, numbers, grid))


def test_undecided_points_are_no_difference_and_cycles_of_one_class_may_be_two() -> None:
    L_s = [[1.0] * 6, [1.0, 1.0 + 1e-8, 1.5, 1.0, 1.0, 1.0]]
    (told,) = reached({"up": "pppupc", "down": "pppeep"}, L_s)
    assert told == {
        "starts": "starts up and down",
        "points": 5,
        "differ": 2,
        "at": ["mu_k = 4 to 5"],
        "cycles": 3,
        "another": 1,
        "another_at": ["mu_k = 2"],
        "stuck": 0,
        "elsewhere": 0,
        "elsewhere_at": [],
        "classes": {"periodic against equilibrium": 1, "chaotic against periodic": 1},
    }
    first, second = over_starts.lines([told])
    assert ": different classes at 2 of 5 points decided, mu_k = 4 to 5 (periodic against" in first
    assert second.endswith(
        "another periodic motion at 1 of 3 points where several were found periodic, mu_k = 2"
    )


def test_cycles_without_a_measure_of_vibration_are_told_apart_by_their_range() -> None:
    """Where nothing slides at rest there is no L_s."""
    grid = data.axes(initial=["up", "down"], mu_k=[1.0, 2.0])
    dataset = data.response(np.full((2, 2), "periodic"), np.full((2, 2), np.nan), grid)
    dataset["x_max"] = (("initial", "mu_k"), [[1.0, 1.0], [1.0, 2.0]])
    (told,) = over_starts.differing(dataset.assign(x_min=-dataset["x_max"]))
    assert (told["cycles"], told["another"], told["another_at"]) == (2, 1, ["mu_k = 2"])
    dataset["L_s"][:, 0] = [np.nan, 0.3]  # the other one's is of another unit than a range
    (told,) = over_starts.differing(dataset.assign(x_min=-dataset["x_max"]))
    assert (told["cycles"], told["another"]) == (2, 1)


def test_a_few_starts_are_told_in_pairs_and_many_together() -> None:
    few = reached({"far": "eepp", "up": "epep", "down": "eeuu"})
    assert [told["differ"] for told in few] == [2, 0, 1]
    assert over_starts.lines(few)[1] == "  starts far and down: the same at all 2 points decided"
    (many,) = reached({"a": "eepp", "b": "eepp", "c": "euup", "d": "epep"})
    assert (many["starts"], many["differ"], many["points"]) == ("all 4 starts", 2, 4)
    assert over_starts.lines([many])[0].endswith("points decided, mu_k = 1 to 2")


def test_starts_that_end_stuck_elsewhere_are_not_the_same() -> None:
    """A box on a belt that stands still stays where friction holds it."""
    table = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"v": 0.0}},
        "initial": [{"kind": "state", "label": n, "state": {"x": x}} for n, x in HELD.items()],
        "analysis": [{"kind": "response"}],
    }
    found = api.run(api.load(table, {"grid.k": [1.0, 2.0]}), workers=1)
    (told,) = over_starts.differing(found)
    assert over_starts.lines([told]) == [
        "  starts here and there: stuck elsewhere at 2 of 2 points where several are stuck, "
        "k = 1 to 2 N m-1"
    ]
    (same,) = over_starts.differing(found.assign(x_max=found["x_max"] * 0.0))
    assert over_starts.lines([same]) == [
        "  starts here and there: the same at all 2 points decided"
    ]


def test_over_several_axes_the_range_of_each_is_told() -> None:
    rows = {"up": "e" * 30, "down": "epepep" * 3 + "e" * 12}
    (told,) = reached(rows, N0=np.arange(5.0), Omega=np.arange(6.0))
    assert told["at"] == ["N0 = 0 to 2 N, Omega = 1 to 5 rad s-1"] and told["differ"] == 9


def test_axes_that_advance_as_one_are_named_at_both_ends_of_a_range() -> None:
    marked = xr.DataArray([False, True, True], {"N0": ("pair", [1.0, 2.0, 3.0])}, ["pair"])
    both = marked.assign_coords(Omega=("pair", [6.0, 5.0, 4.0]))
    assert [*stretches(both)] == ["N0 = 2, Omega = 5 to N0 = 3, Omega = 4"]
    assert [*stretches(marked)] == ["N0 = 2 to 3"]


@pytest.mark.parametrize("rows", [{"up": "ep"}, {"up": "uu", "down": "ee"}])
def test_nothing_is_said_where_nothing_can_be_compared(rows: dict[str, str]) -> None:
    assert over_starts.lines(reached(rows)) == []


def test_shares_of_random_starts_are_told_cycle_by_cycle_where_there_are_several() -> None:
    found = data.basin(count=100, speeds=(1.0, 2.0))
    is_cycle = is_class(found["attractor"], ("periodic",)).values
    large = found["initial_state"].sel(state="x").values > 0.0
    found["L_s"] = found["L_s"].dims, np.where(is_cycle, np.where(large, 2.0, 1.0), 0.0)
    found["L_s"][1] = np.where(is_cycle[1], 1.0, 0.0)
    found["period"] = found["L_s"].dims, np.where(is_cycle, 3.0 * found["L_s"].values, np.nan)
    rows = shares.of_cycles(found)["any"]
    counts = [(is_cycle[0] & ~large[0]).sum(), (is_cycle[0] & large[0]).sum()]
    assert [row["share"][0] for row in rows] == [count / 100 for count in counts]
    assert [(row["Omega"], row["period"]) for row in rows] == [(1.0, 3.0), (1.0, 6.0)]
    assert "any, cycle by cycle" in shares.lines_of_cycles({"any": rows})[0]


def test_shares_of_a_lattice_of_starts_are_told_at_each_point_without_an_error() -> None:
    axes = {"v": [1.0, 2.0], "initial_x": [0.0, 1.0], "initial_x_dot": [0.0, 1.0, 2.0]}
    classes = np.full((2, 2, 3, 1), "periodic", object)
    classes[0, 0] = "equilibrium"
    grid = data.axes(**axes, initial=["plane"])
    found = data.response(classes, np.zeros(classes.shape), grid)
    rows = shares.at_each_point(found)["plane"]
    assert [row["v"] for row in rows] == [1.0, 2.0]
    assert [(row["periodic"][0], row["periodic"][2]) for row in rows] == [(0.5, 6), (1.0, 6)]
    assert np.isnan([row["periodic"][1] for row in rows]).all()
    assert shares.lines_of_points({"plane": rows})[-1].split() == ["2", "0", "1"]
    (line,) = shares.lines(shares.shares(found.isel(v=[1])))
    assert line.split() == ["shares", "of", "plane", "periodic", "1"]
