"""Whatever asks a run to end, and whenever: it ends, alone, quietly, and loses nothing finished."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from disturbed import ENDING, FIV, PATIENCE, Run, ignoring, in_the_background, wait_for
from small_cases import ENDLESS, FAR

from fiv_cli.data.hdf5 import read_attributes

SEED = 20
STATUS = ("status", "case.toml", "-o", "a.nc")
WORKERS = ("--time-limit", "600")  # starts workers at once
POINTS = FAR.format(v=10, N=80, transient=1000.0, t_max=2000.0)


def grouped(count: int) -> str:
    """A case of so many analyses of two points."""
    head, _, _ = POINTS.partition("N = ")
    analyses = (f'[[analysis]]\nkind = "equilibrium"\nname = "a{i}"\n' for i in range(count))
    return head.replace("10", "2") + "".join(analyses)


GROUPS = grouped(60)


def run(folder: Path, text: str, *options: str, **named: object) -> Run:
    """`fiv run` of a case in `folder`."""
    (folder / "case.toml").write_text(text)
    return Run(("run", "case.toml", "-o", "a.nc", *options), folder, **named)  # type: ignore[arg-type]


def finished(folder: Path, text: str, *options: str) -> bytes:
    """The dataset of a run that nobody disturbs."""
    with run(folder, text, *options) as undisturbed:
        assert undisturbed.code(120.0) == 0, undisturbed.said
    return (folder / "a.nc").read_bytes()


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run directory with all the points of GROUPS, and beside it their dataset."""
    folder = tmp_path_factory.mktemp("stored")
    finished(folder, GROUPS)
    return folder / "a.run"


@pytest.fixture(scope="module")
def datasets(tmp_path_factory: pytest.TempPathFactory, stored: Path) -> dict[str, bytes]:
    """Case text -> its dataset."""
    points = finished(tmp_path_factory.mktemp("undisturbed"), POINTS)
    return {POINTS: points, GROUPS: stored.with_suffix(".nc").read_bytes()}


# --- one fault each -------------------------------------------------------------------------------
@pytest.mark.parametrize("number", ENDING)
def test_a_long_integration_is_ended(tmp_path: Path, number: signal.Signals) -> None:
    with run(tmp_path, ENDLESS, "--workers", "1") as endless:
        wait_for(lambda: "0 already stored" in endless.said, "it does not begin")
        time.sleep(2.0)  # into compiled code
        endless.send(number)
        assert endless.code(10.0) == 128 + number
        assert (
            "no point is done, and there is no dataset; the same command begins again"
            in endless.said
        )


def test_that_it_may_take_hours_is_told_before_it_begins(tmp_path: Path) -> None:
    with run(tmp_path, ENDLESS, "--workers", "1") as long:
        wait_for(lambda: "may take more than an hour" in long.said, "nothing is told")
        long.send(signal.SIGINT)
        assert long.code(10.0) == 130
    assert re.search(r"response takes .* given up after 1 s and taken as", long.said)
    with run(tmp_path, POINTS, "--workers", "1", "--max-points", "20", "--fresh") as short:
        assert short.code(60.0) == 8
        assert "an hour" not in short.said and "takes" not in short.said


def test_what_there_is_becomes_a_dataset_and_then_the_whole_one(
    tmp_path: Path, datasets: dict[str, bytes]
) -> None:
    with run(tmp_path, POINTS, *WORKERS) as ended:
        wait_for(lambda: list(tmp_path.glob("a.run/shards/*.h5")), "no progress")
        ended.send(signal.SIGINT, to_all=True)
        assert ended.code(10.0) == 130
    done, points = read_attributes(tmp_path / "a.nc")["partial"].split(" of ")
    assert ended.said.count(points) == 2  # at the beginning, and once in the end
    assert f"a.nc: {points}: {done} ok" in ended.said
    assert ended.said.endswith("interrupted: a.nc holds what is done, and is marked partial\n")
    assert finished(tmp_path, POINTS) == datasets[POINTS]


@pytest.mark.parametrize(("number", "pause"), [*zip(ENDING, (0.1, 0.0, 0.3), strict=True)])
def test_while_the_dataset_is_written(
    tmp_path: Path,
    datasets: dict[str, bytes],
    stored: Path,
    number: signal.Signals,
    pause: float,
) -> None:
    """One signal leaves it its time."""
    shutil.copytree(stored, tmp_path / "a.run")
    with run(tmp_path, GROUPS, "--workers", "1") as writing:
        wait_for(lambda: list(tmp_path.glob(".a.nc*")), "nothing is written")
        time.sleep(pause)
        writing.send(number)
        assert writing.code(10.0) == 128 + number
    assert writing.said.endswith(": a.nc is whole\n")
    assert (tmp_path / "a.nc").read_bytes() == datasets[GROUPS]
    assert not list(tmp_path.glob(".a.nc*"))


def test_a_second_signal_while_the_dataset_is_written(
    tmp_path: Path, datasets: dict[str, bytes], stored: Path
) -> None:
    shutil.copytree(stored, tmp_path / "a.run")
    with run(tmp_path, GROUPS, "--workers", "1") as writing:
        wait_for(lambda: list(tmp_path.glob(".a.nc*")), "nothing is written")
        writing.send(signal.SIGINT)
        time.sleep(0.6)  # sooner it counts as the same
        writing.send(signal.SIGINT)
        assert writing.code(10.0) == 130
    if (tmp_path / "a.nc").exists():
        assert (tmp_path / "a.nc").read_bytes() == datasets[GROUPS]
    else:
        assert writing.said.endswith("every point is stored; the same command writes the dataset\n")


@pytest.mark.parametrize("pause", [0.02, 0.05, 0.08])
def test_a_second_ctrl_c(tmp_path: Path, pause: float) -> None:
    with run(tmp_path, ENDLESS, *WORKERS) as impatient:
        wait_for(lambda: len(impatient.processes()) >= 3, "no workers")
        time.sleep(10 * pause)  # they import, then compute
        impatient.send(signal.SIGINT, to_all=True)
        time.sleep(pause)
        impatient.send(signal.SIGINT, to_all=True)
        assert impatient.code(10.0) == 130
        assert "Traceback" not in impatient.said


def test_what_is_ignored_on_entry_stays_ignored_without_any_other_program(
    tmp_path: Path, datasets: dict[str, bytes]
) -> None:
    """No `pgrep`, no `ps`, no psutil: as in an image with Python alone."""
    (tmp_path / "psutil.py").write_text("raise ImportError")
    bare = {"PATH": "", "PYTHONPATH": f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}"}
    with run(tmp_path, POINTS, *WORKERS, environment=bare, entry=ignoring) as background:
        wait_for(lambda: len(background.processes()) >= 3, "no workers")
        for number in ENDING:
            background.send(number, to_all=True)
        assert background.code() == 0
        assert "`kill " not in background.said  # which is ignored too
    assert (tmp_path / "a.nc").read_bytes() == datasets[POINTS]


def test_how_fast_it_goes_is_told_elsewhere_while_it_runs_and_afterwards(tmp_path: Path) -> None:
    text = POINTS.replace("num = 80", "num = 12000")
    with run(tmp_path, text, *WORKERS) as watched:
        wait_for(lambda: len(list(tmp_path.glob("a.run/shards/*.h5"))) > 4, "no progress")
        live, shown = (other(tmp_path, *w) for w in (STATUS, ("show", "a.nc")))
        watched.send(signal.SIGINT)
        assert watched.code(10.0) == 130
    pace = r": \S+ s elapsed, \S+ points/s"  # how long it takes is told when more is known
    assert re.search(rf"process {watched.process.pid} is running it{pace}", live)
    assert re.search(r"120000 points done\n  \d+ ok, \d+ pending\n  response: \w+ \d+", live)
    assert re.search(r"a\.nc: not written; its run had \d+ of 120000 points done at", shown)
    assert "next: fiv status case.toml -o a.nc;" in shown
    told = json.loads(other(tmp_path, *STATUS, "--json"))
    assert told["elapsed"] > 0.0 and told["rate"] > 0.0
    assert re.search(rf"the last run that computed points{pace}", other(tmp_path, *STATUS))


def other(folder: Path, *arguments: str) -> str:
    """What another command says, which is carried out to its end."""
    done = subprocess.run([*FIV, *arguments], cwd=folder, capture_output=True, text=True)
    return done.stdout + done.stderr


def test_a_job_in_the_background_of_a_script_says_what_ends_it(tmp_path: Path) -> None:
    """A shell has it ignore SIGINT, so that Ctrl-C at the script leaves it alone."""
    with run(tmp_path, POINTS, *WORKERS, entry=in_the_background) as background:
        wait_for(lambda: list(tmp_path.glob("a.run/shards/*.h5")), "no progress")
        background.send(signal.SIGINT, to_all=True)
        assert f"`kill {background.process.pid}` does" in background.said
        background.send(signal.SIGTERM)
        assert background.code(10.0) == 143
        assert background.said.endswith(
            "terminated: a.nc holds what is done, and is marked partial\n"
        )


def test_nothing_is_left_in_shared_memory(tmp_path: Path) -> None:
    with run(tmp_path, POINTS, *WORKERS) as killed:
        wait_for(lambda: list(tmp_path.glob("a.run/shards/*.h5")), "no progress")
        killed.send(signal.SIGKILL, to_all=True)
        assert killed.code() == -9
        assert not list(Path("/dev/shm").glob(f"*-{killed.process.pid}-*"))


# --- at any instant -------------------------------------------------------------------------------
@dataclass(frozen=True)
class Scene:
    """A run to be disturbed.

    Attributes
    ----------
    text : its case
    options : of `fiv run`
    cold : nothing is compiled yet
    stored : all points are stored, only the dataset is missing
    when : whether the part has begun that is to be disturbed
    seconds : in which a signal comes after that
    """

    text: str
    options: tuple[str, ...]
    when: Callable[[Run, Path], bool]
    seconds: float
    cold: bool = False
    stored: bool = False


def _listens(run: Run, folder: Path) -> bool:
    return run.listens()


def _computes(run: Run, folder: Path) -> bool:
    return "already stored" in run.said


def _stores(run: Run, folder: Path) -> bool:
    return bool(list(folder.glob("a.run/shards/*.h5")))


def _assembles(run: Run, folder: Path) -> bool:
    return run.process.poll() is not None or "0 to run" in run.said


ONE, TWO = ("--workers", "1"), ("--workers", "2", *WORKERS)
SCENES = {
    "importing": Scene(POINTS, TWO, _listens, 0.8),
    "compiling": Scene(POINTS, ONE, _listens, 20.0, cold=True),
    "computing": Scene(POINTS, ONE, _computes, 2.0),
    "starting workers": Scene(POINTS, TWO, _computes, 2.0),
    "storing": Scene(POINTS, TWO, _stores, 1.0),
    "assembling": Scene(GROUPS, ONE, _assembles, 1.5, stored=True),
}
SHARES = (2, 1, 2, 3, 3, 3)  # of the trials
NUMBERS = (*ENDING, signal.SIGKILL)


@dataclass(frozen=True)
class Trial:
    """Signals at an instant."""

    scene: str
    numbers: tuple[signal.Signals, ...]
    instant: float
    pause: float
    to_all: bool


def trials(seed: int, count: int, scenes: dict[str, Scene] = SCENES) -> list[Trial]:
    """Random trials."""
    chance = random.Random(seed)
    shares = [share for name, share in zip(SCENES, SHARES, strict=True) if name in scenes]
    return [
        Trial(
            name := chance.choices(list(scenes), shares)[0],
            tuple(chance.choices(NUMBERS, k=chance.choice((1, 2)))),
            chance.uniform(0.0, scenes[name].seconds),
            chance.uniform(0.02, 0.08),
            chance.random() < 0.5,
        )
        for _ in range(count)
    ]


def assert_survives(trial: Trial, folder: Path, datasets: dict[str, bytes], stored: Path) -> bool:
    """Disturb a run, then let it go on; whether it was ended before it had finished."""
    scene = SCENES[trial.scene]
    if scene.stored:
        shutil.copytree(stored, folder / "a.run")
    own = {"FIV_CACHE_DIR": str(folder / "cache")} if scene.cold else {}
    with run(folder, scene.text, *scene.options, environment=own) as disturbed:
        wait_for(lambda: scene.when(disturbed, folder), f"{trial}: never begins")
        time.sleep(trial.instant)
        for number in trial.numbers:
            disturbed.send(number, trial.to_all)
            time.sleep(trial.pause)
        code = disturbed.code(PATIENCE)
        assert "Traceback" not in disturbed.said, f"{trial}: {disturbed.said}"
        expected = {0} | {-9 if n == signal.SIGKILL else 128 + n for n in trial.numbers}
        assert code in expected, f"{trial}: {code}: {disturbed.said}"
    assert finished(folder, scene.text, *scene.options) == datasets[scene.text], trial
    assert not list(folder.glob(".*")), trial
    return code != 0


QUICK = {name: scene for name, scene in SCENES.items() if not scene.cold}


@pytest.mark.parametrize("trial", trials(SEED, 10, QUICK), ids=lambda trial: trial.scene)
def test_signals_at_any_instant(
    tmp_path: Path, datasets: dict[str, bytes], stored: Path, trial: Trial
) -> None:
    assert_survives(trial, tmp_path, datasets, stored)


@pytest.mark.campaign
def test_two_hundred_times(tmp_path: Path, datasets: dict[str, bytes], stored: Path) -> None:
    seed = int(os.environ.get("FIV_TEST_SEED", SEED))
    print(f"seed {seed} (FIV_TEST_SEED)")
    ended = 0
    for number, trial in enumerate(trials(seed, 200)):
        folder = tmp_path / str(number)
        folder.mkdir()
        ended += assert_survives(trial, folder, datasets, stored)
        shutil.rmtree(folder)
    print(f"{ended} of 200 were ended before they had finished")
    assert ended > 120
