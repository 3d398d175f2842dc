"""However a sweep is run, its dataset is the same to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from clusters import LoopbackCluster

from fiv_cli.case.load import parse_case
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.sweep.parts import Part
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.run import assemble_case, run_case

CASE = """
schema = 1
[model]
name = "pin-on-disc"
parameters = { Omega = 5.0 }
[grid]
N0 = [20.0, 30.0, 40.0]
mu_k = { start = 0.05, stop = 0.37, num = 3 }
[sweep]
refine = { levels = 2, of = "attractor", along = ["mu_k"], sample = 1 }
[[initial]]
label = "disc-speed"
kind = "state"
state = { phi_dot = "Omega" }
[[initial]]
label = "followed"
kind = "continue"
along = "N0"
direction = "down"
from = "disc-speed"
[[analysis]]
name = "branch"
kind = "cycle"
section = { event = "slip->stick" }
observe = "phi"
transient = 2.0
t_max = 4.0
parameter = "Omega"
bracket = [4.9, 5.2]
[[analysis]]
kind = "response"
section = { event = "slip->stick" }
observe = "phi"
t_max = 50.0
"""
"""Followed branches of cycles; maps of responses that are refined across chains."""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LoopbackCluster]:
    """Two workers."""
    with LoopbackCluster(tmp_path_factory.mktemp("cluster")) as running:
        running.start_worker(processes=2)
        yield running


def test_however_it_is_run(tmp_path: Path, cluster: LoopbackCluster) -> None:
    case = parse_case(CASE, "case.toml")

    def run(name: str, **policy: object) -> None:
        own = {"workers": 1, "in_process_below": 0.0, **policy}
        run_case(case, tmp_path / f"{name}.nc", Policy(**own), Silent())  # type: ignore[arg-type]

    run("reference")
    run("four", workers=4, chunk_points=3)
    run("cluster", cluster=cluster.address, chunk_points=2)
    for place, points in ((cluster.address, 3), ("", 4), (cluster.address, 5)):
        run("here and there", cluster=place, max_points=points, chunk_points=points)
    run("here and there", workers=2, chunk_points=1)
    run("parts", part=Part(3, 3), chunk_points=1)
    run("parts", part=Part(1, 3), max_points=2)
    run("parts", part=Part(2, 3), cluster=cluster.address)
    run("parts", part=Part(1, 3), workers=2)
    assert assemble_case(case, tmp_path / "parts.nc")[1] == []
    expected = (tmp_path / "reference.nc").read_bytes()
    found = {path.stem: path.read_bytes() == expected for path in tmp_path.glob("*.nc")}
    assert len(found) == 5
    assert all(found.values()), found


def test_a_chain_is_run_whole_and_as_in_the_full_grid(tmp_path: Path) -> None:
    full = CASE.replace("num = 3 }", "num = 9 }").replace("refine = {", "# refine = {")
    found = {}
    for name, text in (("refined", CASE), ("full", full)):
        policy = Policy(workers=1, in_process_below=0.0)
        run_case(parse_case(text, "case.toml"), tmp_path / f"{name}.nc", policy, Silent())
        found[name] = read_datasets(tmp_path / f"{name}.nc")["response"]
    was_run = found["refined"]["computed"] > 0
    followed = was_run.sel(initial="followed")
    assert (followed.any("N0") == followed.all("N0")).all()
    assert 0 < int(was_run.sum()) < was_run.size
    for name in ("status", "attractor", "period", "n_steps"):
        here, there = (found[one][name].where(was_run) for one in ("refined", "full"))
        assert here.equals(there), name
