"""A real `fiv run`, ended in every way: no process stays behind, nothing finished is lost."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from disturbed import Run, wait_for
from small_cases import FAR

from fiv_cli.data.hdf5 import read_attributes

CASE = FAR.format(v=20, N=50, transient=3e3, t_max=6e3)

PATIENCE = 60.0
COMMAND = ("run", "case.toml", "-o", "a.nc", "--time-limit", "600")  # starts workers at once


def begun(folder: Path) -> Run:
    """`fiv run` of the case in a process of its own."""
    (folder / "case.toml").write_text(CASE)
    return Run(COMMAND, folder)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The dataset of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("undisturbed")
    with begun(folder) as run:
        assert run.code(2 * PATIENCE) == 0
    return (folder / "a.nc").read_bytes()


def workers_of(run: Run) -> list[int]:
    """The worker processes, which are those that compute."""
    others = [pid for pid in run.processes() if pid != run.process.pid]
    return [pid for pid in others if b"resource_tracker" not in command_line(pid)]


def command_line(pid: int) -> bytes:
    """What a process was started as; one that has ended is none of the workers."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b"resource_tracker"


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Run]:
    """A run in mid-flight, its workers at work."""
    with begun(tmp_path) as run:
        wait_for(lambda: stored(tmp_path) >= 2 and workers_of(run), "no progress", PATIENCE)
        yield run


def stored(folder: Path) -> int:
    """Number of finished chunks."""
    return len(list((folder / "a.run" / "shards").glob("*.h5")))


def assert_resumes_to(folder: Path, expected: bytes) -> None:
    """The same command goes on from what is stored and ends with the same dataset."""
    assert stored(folder) > 0
    assert not (folder / "a.nc").exists() or "partial" in read_attributes(folder / "a.nc")
    with begun(folder) as again:
        assert again.code(PATIENCE) == 0
        assert ", 0 already stored" not in again.said
    assert (folder / "a.nc").read_bytes() == expected
    assert not list((folder / "a.run").glob(".beat-*"))


@pytest.mark.parametrize(
    ("number", "to_all", "code"),
    [
        (signal.SIGKILL, False, -9),
        (signal.SIGTERM, False, 143),
        (signal.SIGINT, False, 130),
        (signal.SIGINT, True, 130),  # Ctrl-C in a terminal
    ],
)
def test_the_parent_ends(
    tmp_path: Path, undisturbed: bytes, running: Run, number: int, to_all: bool, code: int
) -> None:
    running.send(number, to_all)
    assert running.code(PATIENCE) == code
    assert_resumes_to(tmp_path, undisturbed)


def test_a_killed_worker_is_replaced(tmp_path: Path, undisturbed: bytes, running: Run) -> None:
    os.kill(workers_of(running)[0], signal.SIGKILL)
    assert running.code(PATIENCE) == 0
    assert (tmp_path / "a.nc").read_bytes() == undisturbed
    assert "a worker died" in (tmp_path / "a.run" / "run.log").read_text()


def test_a_second_run_is_refused_while_the_first_is_alive(tmp_path: Path, running: Run) -> None:
    running.send(signal.SIGSTOP)  # alive, but it will not end meanwhile
    with begun(tmp_path) as second:
        assert second.code(PATIENCE) == 7
        assert str(running.process.pid) in second.said
