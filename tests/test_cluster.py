"""Sweeps on a cluster: a scheduler and workers in processes of their own, ended in every way."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import random
import re
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import own_models
import pytest
import sweep_fakes
from clusters import Dask, LoopbackCluster
from disturbed import Run, wait_for
from small_cases import ENDLESS, FAR

import fiv_cli
from fiv_cli.case.case import Case
from fiv_cli.case.load import load_case, parse_case
from fiv_cli.errors import ClusterError, StoreMismatchError
from fiv_cli.own.probe import use_files
from fiv_cli.sweep import cluster as clusters
from fiv_cli.sweep.journal import Journal
from fiv_cli.sweep.parts import Part
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.queue import Queue
from fiv_cli.sweep.run import Summary, assemble_case, run_case

PATIENCE = 60.0
DEADLY = "sweep_fakes:deadly_once"
HERE = Policy(workers=1, executor="sweep_fakes:answer", preparer="sweep_fakes:prepare")
CASE = FAR.format(v=20, N=50, transient=2000.0, t_max=4000.0)
LONG = sweep_fakes.BELT.replace("stop = 5, num = 5", "stop = 200, num = 200")


class Notes(Silent):
    """Keeps what is said."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def note(self, text: str) -> None:
        self.said.append(text)


def sweep(output: Path, text: str, cluster: LoopbackCluster | None, **changes: Any) -> Summary:
    """Run a case from text, on a cluster or here."""
    place = "" if cluster is None else cluster.address
    policy = dataclasses.replace(HERE, cluster=place, **changes)
    return run_case(sweep_fakes.case(text), output, policy, changes.pop("progress", Silent()))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LoopbackCluster]:
    """A scheduler with two workers, which nobody disturbs."""
    with LoopbackCluster(tmp_path_factory.mktemp("cluster")) as running:
        environment = {"FIV_TEST_COUNT": str(running.folder / "count")}
        running.start_worker(processes=2, environment=environment)
        yield running


@pytest.mark.parametrize(
    "text",
    [sweep_fakes.BELT, sweep_fakes.LOOP, sweep_fakes.REFINED],
    ids=["map", "loop", "refined"],
)
def test_a_cluster_leaves_no_trace(tmp_path: Path, cluster: LoopbackCluster, text: str) -> None:
    executor = "sweep_fakes:region" if text == sweep_fakes.REFINED else "sweep_fakes:answer"
    sweep(tmp_path / "a.nc", text, None, executor=executor)
    expected = (tmp_path / "a.nc").read_bytes()
    sweep(tmp_path / "b.nc", text, cluster, executor=executor, chunk_points=5)
    assert (tmp_path / "b.nc").read_bytes() == expected
    for where in (None, cluster, None):  # to a cluster and back in the middle of a sweep
        sweep(tmp_path / "c.nc", text, where, executor=executor, max_points=7)
    sweep(tmp_path / "c.nc", text, cluster, executor=executor)
    assert (tmp_path / "c.nc").read_bytes() == expected


def test_that_it_may_take_hours_is_told_for_as_many_workers_as_have_joined(
    tmp_path: Path, cluster: LoopbackCluster
) -> None:
    class Enough(Exception):
        pass

    class Told(Notes):
        def note(self, text: str) -> None:
            super().note(text)
            if "may take more than an hour" in text:
                raise Enough

    # else its first point ends by its events in just less than the time that it is given
    endless = ENDLESS.replace("[solver]", "[solver]\nmax_events = 1000000000000")
    told, policy = Told(), Policy(cluster=cluster.address, workers=1, foresee=True)
    with pytest.raises(Enough):
        run_case(parse_case(endless, "endless.toml"), tmp_path / "a.nc", policy, told)
    assert re.search("response takes .* on [12] worker", " ".join(told.said))


def test_a_point_that_ends_its_process_fails_alone(
    tmp_path: Path, cluster: LoopbackCluster
) -> None:
    summary = sweep(tmp_path / "a.nc", sweep_fakes.BELT, cluster, executor="sweep_fakes:deadly")
    assert summary.counts["failed"] == 2
    assert "worker died twice" in summary.errors[0][0]
    sweep(tmp_path / "a.nc", sweep_fakes.BELT, cluster)
    sweep(tmp_path / "b.nc", sweep_fakes.BELT, None)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_process_that_died_once_costs_nothing(tmp_path: Path, cluster: LoopbackCluster) -> None:
    sweep(tmp_path / "a.nc", sweep_fakes.LOOP, None)
    assert sweep(tmp_path / "b.nc", sweep_fakes.LOOP, cluster, executor=DEADLY).complete
    assert (cluster.folder / "count").exists()
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


@pytest.mark.campaign
def test_a_wall_clock_limit_ends_one_point(tmp_path: Path, cluster: LoopbackCluster) -> None:
    summary = sweep(
        tmp_path / "a.nc", sweep_fakes.BELT, cluster, executor="sweep_fakes:endless", time_limit=0.5
    )
    assert summary.counts["failed"] == 2
    assert "longer than 0.5 s" in summary.errors[0][0]


def own_case(folder: Path, text: str) -> Case:
    """A case of a model in a file that is gone before anything runs."""
    file, case = folder / "my.py", folder / "case.toml"
    file.write_text(text)
    case.write_text(own_models.CASE)
    use_files([file])
    file.unlink()
    return load_case(case)


def test_a_model_of_ones_own_runs_on_a_cluster_and_in_parts_and_meets_no_older_text(
    tmp_path: Path, cluster: LoopbackCluster
) -> None:
    """Workers have no file of it, and go on living when its text has changed."""
    stiffer = own_models.MODEL.replace('p("k3") *', '2 * p("k3") *')
    found, parts = [], tmp_path / "parts.nc"
    for text in (own_models.MODEL, stiffer):
        case = own_case(tmp_path, text)
        one, far = (tmp_path / f"{len(found)}-{place}.nc" for place in ("one", "far"))
        run_case(case, one, Policy(workers=1), Silent())
        run_case(case, far, Policy(cluster=cluster.address, chunk_points=1), Silent())
        run_case(case, parts, Policy(workers=1, part=Part(2, 2)), Silent())
        run_case(case, parts, Policy(workers=1, part=Part(1, 2)), Silent())
        assert assemble_case(case, parts)[0].complete
        found.append(one.read_bytes())
        assert far.read_bytes() == parts.read_bytes() == found[-1]
        parts.unlink()
        shutil.move(parts.with_suffix(".run"), tmp_path / f"{len(found)}.run")
    use_files(())
    assert found[0] != found[1]
    shutil.move(tmp_path / "1.run", parts.with_suffix(".run"))  # of the text before
    for refused in (
        lambda: run_case(case, parts, Policy(workers=1, part=Part(1, 2)), Silent()),
        lambda: assemble_case(case, parts),
    ):
        with pytest.raises(StoreMismatchError, match=r"my\.py was changed since"):
            refused()


def test_workers_of_another_version_are_refused(tmp_path: Path) -> None:
    other = tmp_path / "other"
    package = Path(fiv_cli.__file__).parent
    shutil.copytree(package, other / "fiv_cli", ignore=shutil.ignore_patterns("__pycache__"))
    (other / "fiv_cli" / "__init__.py").write_text('__version__ = "9.9"\n')
    notes = Notes()
    with LoopbackCluster(tmp_path) as cluster:
        paths = os.pathsep.join([str(other), str(Path(__file__).parent)])
        worker = cluster.start_worker("--no-nanny", environment={"PYTHONPATH": paths})
        wait_for(lambda: "Registered to" in worker.said, "no worker")
        policy = dataclasses.replace(HERE, cluster=cluster.address)
        with pytest.raises(ClusterError, match="no worker there would compute the same bits"):
            run_case(sweep_fakes.case(), tmp_path / "a.nc", policy, notes)
    refused = next(said for said in notes.said if "is refused" in said)
    assert "fiv 9.9" in refused
    assert f"fiv {fiv_cli.__version__}" not in refused.partition("there,")[0]


def test_workers_join_and_die_and_the_scheduler_comes_back(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc", sweep_fakes.BELT, None)
    output, notes = tmp_path / "b.nc", Notes()
    shards = tmp_path / "b.run" / "shards"
    with LoopbackCluster(tmp_path) as cluster:
        policy = dataclasses.replace(
            HERE, cluster=cluster.address, executor="sweep_fakes:slow", chunk_points=2
        )
        case = sweep_fakes.case()
        run = threading.Thread(target=run_case, args=(case, output, policy, notes))
        run.start()
        wait_for(lambda: any("0 tasks" in said for said in notes.said), "it does not wait")
        first = cluster.start_worker("--no-nanny")
        wait_for(lambda: list(shards.glob("*.h5")), "nothing is computed")
        second = cluster.start_worker("--no-nanny")
        wait_for(lambda: any("2 tasks" in said for said in notes.said), "nobody joins")
        kill(first)
        done = newest(shards)
        wait_for(lambda: newest(shards) > done, "it does not go on")
        cluster.kill_scheduler()
        kill(second)
        cluster.start_scheduler()
        cluster.start_worker("--no-nanny")
        run.join(PATIENCE)
        assert not run.is_alive()
    assert output.read_bytes() == (tmp_path / "a.nc").read_bytes()


def test_a_result_that_went_with_its_worker_is_computed_again(tmp_path: Path) -> None:
    """It was waited for as long as for a scheduler, and sent to nobody meanwhile."""
    journal = Journal(tmp_path, make_plan(sweep_fakes.case()))
    queue = Queue(journal.plan.analyses[0], journal.records[0], "sweep_fakes:answer")
    job = queue.next_job(2)
    assert job is not None
    with LoopbackCluster(tmp_path) as running:
        holding = running.start_worker("--no-nanny")
        wait_for(lambda: "Registered to" in holding.said, "no worker")
        workers = clusters.Cluster(running.address, lambda text: None)
        number = workers.submit(job.task)
        wait_for(lambda: workers._status(number) == "finished", "it is not computed")
        kill(holding)
        running.start_worker("--no-nanny")
        found: list[Any] = []
        wait_for(lambda: found.extend(workers.completed(0.1)) or found, "it is not computed again")
        workers.close()
    assert [one for one, _ in found] == [number]


def test_a_scheduler_that_stays_away_ends_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clusters, "PATIENCE", 2.0)
    with LoopbackCluster(tmp_path) as cluster:
        cluster.start_worker("--no-nanny")
        killer = threading.Thread(target=_kill_when_something_is_stored, args=(cluster, tmp_path))
        killer.start()
        with pytest.raises(ClusterError, match="has not come back"):
            sweep(
                tmp_path / "a.nc",
                sweep_fakes.BELT,
                cluster,
                executor="sweep_fakes:slow",
                chunk_points=2,
            )
        killer.join()
        with pytest.raises(ClusterError, match="no scheduler answers"):
            sweep(tmp_path / "a.nc", sweep_fakes.BELT, cluster)
    assert 0 < sweep(tmp_path / "a.nc", sweep_fakes.BELT, None).ran < 30
    sweep(tmp_path / "b.nc", sweep_fakes.BELT, None)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def _kill_when_something_is_stored(cluster: LoopbackCluster, folder: Path) -> None:
    wait_for(lambda: list((folder / "a.run" / "shards").glob("*.h5")), "nothing is stored")
    cluster.kill_scheduler()


@pytest.mark.campaign
def test_ctrl_c_and_the_same_command_again(tmp_path: Path, cluster: LoopbackCluster) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    command = ("run", "case.toml", "-o", "a.nc", "--cluster", cluster.address)
    shards = tmp_path / "a.run" / "shards"
    with Run(command, tmp_path) as run:
        wait_for(lambda: len(list(shards.glob("*.h5"))) >= 2, "no progress", PATIENCE)
        run.send(signal.SIGINT)
        assert run.code(PATIENCE) == 130
        assert "points" in run.said
    with Run(command, tmp_path) as again:
        assert again.code(PATIENCE) == 0
    with Run(("run", "case.toml", "-o", "b.nc"), tmp_path) as here:
        assert here.code(PATIENCE) == 0
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_what_is_dropped_computes_no_longer(cluster: LoopbackCluster, tmp_path: Path) -> None:
    journal = Journal(tmp_path, make_plan(sweep_fakes.case()))
    queue = Queue(journal.plan.analyses[0], journal.records[0], "sweep_fakes:endless")
    job = queue.next_job(queue.left)
    assert job is not None
    workers = clusters.Cluster(cluster.address, lambda text: None)
    number = workers.submit(job.task)
    wait_for(lambda: computing(cluster), "nobody begins")
    running = len(computing(cluster))
    assert (workers.completed(1.0), workers.lost(), number) == ([], [], 1)
    workers.close()
    wait_for(lambda: len(computing(cluster)) < running, "a process goes on")


def computing(cluster: LoopbackCluster) -> list[int]:
    """Processes that the workers have started."""
    pids = [pid for worker in cluster.workers for pid in worker.processes()]
    return [pid for pid in pids if b"popen_loky" in Path(f"/proc/{pid}/cmdline").read_bytes()]


@pytest.mark.campaign
def test_fifty_kills_of_workers_and_five_of_the_scheduler(tmp_path: Path) -> None:
    """Nothing is lost, whatever is killed: about three minutes."""
    sweep(tmp_path / "a.nc", LONG, None)
    output, chance = tmp_path / "b.nc", random.Random(1)
    policy = Policy(executor="sweep_fakes:slow", preparer="sweep_fakes:prepare", chunk_points=3)
    shards = tmp_path / "b.run" / "shards"
    with LoopbackCluster(tmp_path) as cluster:
        policy = dataclasses.replace(policy, cluster=cluster.address)
        case = sweep_fakes.case(LONG)
        run = threading.Thread(target=run_case, args=(case, output, policy, Silent()))
        run.start()
        for number in range(1, 56):
            while len(cluster.workers) < 3:
                cluster.start_worker("--no-nanny")
            before = newest(shards)
            wait_for(lambda: newest(shards) > before, "nothing is computed", PATIENCE)  # noqa: B023
            time.sleep(chance.random())
            if number % 11 == 0:
                cluster.kill_scheduler()
                while cluster.workers:
                    kill(cluster.workers.pop())
                cluster.start_scheduler()
            else:
                kill(cluster.workers.pop(chance.randrange(3)))
            assert run.is_alive()
        cluster.start_worker(processes=2)
        run.join(5 * PATIENCE)
        assert not run.is_alive()
    assert output.read_bytes() == (tmp_path / "a.nc").read_bytes()


def newest(shards: Path) -> int:
    """Number of the shard that was stored last."""
    return max((int(path.stem) for path in shards.glob("*.h5")), default=-1)


def kill(worker: Dask) -> None:
    """End a worker and all that it has started, without a word."""
    for pid in worker.processes():
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
