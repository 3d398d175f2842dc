"""What a run will cost: the range holds it, whichever points cost most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_cases import PIN

from fiv_cli import api
from fiv_cli.case.case import Refinement
from fiv_cli.sweep.borders import draw
from fiv_cli.sweep.estimate import OF_TIMING, _spread, estimate
from fiv_cli.sweep.map_estimate import Drawing
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.refine import Maps
from fiv_cli.sweep.run import run_case
from fiv_cli.sweep.worker import ChainState, Segment


@pytest.mark.parametrize("chained", [False, True])
def test_an_estimate_holds_the_time_where_few_points_cost_nearly_all(
    monkeypatch: pytest.MonkeyPatch, chained: bool
) -> None:
    """Of a million points of which one in 25 takes a hundred times as long, in one corner."""
    table: dict[str, Any] = {
        "schema": 1,
        "model": {"name": "belt-1dof"},
        "analysis": [{"kind": "response"}],
    }
    table["grid"] = {axis: {"start": 1.0, "stop": 2.0, "num": 1000} for axis in ("v", "N")}
    table["initial"] = [{"label": "rest", "kind": "state"}]
    if chained:
        followed = {"label": "up", "kind": "continue", "along": "v", "direction": "up"}
        table["initial"].append({**followed, "from": "rest"})
    names = [name for name, _ in make_plan(api.load(table)).analyses[0].template.axes]

    def costs(segments: tuple[Segment, ...]) -> Iterator[float]:
        for values in (values for segment in segments for values in segment.values):
            at = dict(zip(names, values, strict=True))
            yield 1.0 if at["v"] < 1.2 and at["N"] > 1.8 else 0.01

    def timed(_: object, segments: tuple[Segment, ...]) -> tuple[SimpleNamespace, float]:
        state = ChainState(False, {}, "periodic")
        block = SimpleNamespace(nbytes=100 * len(segments))
        return SimpleNamespace(block=block, states={0: state}), sum(costs(segments))

    monkeypatch.setattr("fiv_cli.sweep.estimate._timed", timed)
    (found,) = estimate(api.load(table), 1, lambda _: None)
    low, high = found.seconds
    assert low < (1 + chained) * 1e6 * (0.04 + 0.96 * 0.01) < high < 2.0 * low
    assert found.sampled < 0.02 * found.points[1]


def test_a_sample_is_spread_over_every_axis_and_reaches_every_point() -> None:
    sizes = (4, 3, 50)
    places = np.array(list(_spread(sizes)))
    assert len(places) == 600 == len({tuple(place) for place in places.tolist()})
    first = np.array(list(islice(_spread((4, 3, 10**6)), 120)))
    for axis, bins in ((0, 4), (1, 3), (2, 10)):
        shares = np.bincount(first[:, axis] * bins // (4, 3, 10**6)[axis], minlength=bins) / 120
        assert np.abs(shares * bins - 1.0).max() < 0.25


class Disc(list[int]):
    """Positions in a square, as the block of what is computed there: inside a disc, or outside."""

    nbytes = 1

    @property
    def values(self) -> dict[str, np.ndarray]:
        x, y = np.divmod(np.array(self), 257) / np.float64(256)
        return {"attractor": ((x - 0.4) ** 2 + (y - 0.5) ** 2 < 0.09).astype(np.int32)}


@pytest.mark.parametrize(("seconds", "spread"), [(200, 20.0), (300, 2.0), (1000, 1.2), (1e9, 1.0)])
def test_a_map_grows_as_its_borders_do(
    monkeypatch: pytest.MonkeyPatch, seconds: float, spread: float
) -> None:
    """Each point takes a second; how many there will be is foreseen from those of few levels."""
    square = np.arange(257**2).reshape(257, 257)
    maps = Maps(Refinement(5, "attractor", ("v", "N"), 0, 0), square[None], {"v": 9, "N": 9}, -1)
    picture = draw(
        np.array(maps.classes_of(Disc(square.ravel()))).reshape(257, 257),
        np.ones((257, 257), bool),
        5,
    )
    true, clock = int(picture.wanted.sum()), 0.0

    def run(positions: Sequence[int]) -> tuple[Any, float]:
        nonlocal clock
        clock += len(positions)
        return Disc(positions), float(len(positions))

    monkeypatch.setattr("fiv_cli.sweep.map_estimate.time.monotonic", lambda: clock)
    nothing = np.zeros(square.shape, np.int32), np.zeros(square.shape, bool)
    drawing = Drawing(maps, square, *nothing, run, at_once=10)
    drawing.until(seconds)
    (low, high), (least, most) = drawing.cost()
    assert low * (1 - OF_TIMING) <= true <= high * (1 + OF_TIMING) and high <= spread * low
    assert (least, most) == pytest.approx((low, high))


def test_what_is_stored_is_credited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pin.toml").write_text(PIN)
    case, said = api.load("pin.toml"), list[str]()
    for more, stored in ((1, 1), (1, 2)):
        run_case(case, Path("runs/pin.nc"), Policy(workers=1, max_points=more), Silent())
        found = [(one.points, one.stored) for one in estimate(case, 1, said.append)]
        assert found == [((1, 1), stored)][: 2 - stored]
    assert said[-1] == "every point of equilibrium is stored: nothing is to be run"
