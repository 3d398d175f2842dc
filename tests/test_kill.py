"""A real `fiv run`, ended in every way: no process stays behind, nothing finished is lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from disturbed import by_default

CASE = """
schema = 1
[model]
name = "belt-1dof"
[grid]
v = { start = 0.5, stop = 2.0, num = 20 }
N = { start = 5.0, stop = 20.0, num = 50 }
[[initial]]
label = "far"
kind = "state"
state = { x = 10.0 }
[[analysis]]
kind = "response"
transient = 2000.0
t_max = 4000.0
"""

PATIENCE = 60.0


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The dataset of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "case.toml").write_text(CASE)
    subprocess.run(command(), cwd=folder, check=True, capture_output=True)
    return (folder / "a.nc").read_bytes()


def command() -> list[str]:
    """`fiv run` in a process of its own; a limit per point makes it start workers at once."""
    return [
        sys.executable,
        *("-c", "from fiv_cli.cli.main import main; main()"),
        *("run", "case.toml", "-o", "a.nc", "--time-limit", "600"),
    ]


def descendants(pid: int) -> set[int]:
    """Processes below `pid`."""
    try:
        threads = list(Path(f"/proc/{pid}/task").iterdir())
        children = {int(c) for t in threads for c in (t / "children").read_text().split()}
    except OSError:
        return set()
    return children.union(*(descendants(child) for child in children))


def alive(pid: int) -> bool:
    """Whether a process runs (and is not merely waiting to be buried)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def workers_of(pid: int) -> list[int]:
    """The worker processes, which are those that compute."""
    return [child for child in descendants(pid) if b"resource_tracker" not in command_line(child)]


def command_line(pid: int) -> bytes:
    """What a process was started as; one that has ended is none of the workers."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b"resource_tracker"


def wait_for(condition: Callable[[], object], what: str) -> None:
    """Wait until something holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.02)


@pytest.fixture
def running(tmp_path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A run in mid-flight, its workers at work."""
    (tmp_path / "case.toml").write_text(CASE)
    process = subprocess.Popen(
        command(),
        cwd=tmp_path,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=by_default,
    )
    try:
        wait_for(lambda: stored(tmp_path) >= 2 and workers_of(process.pid), "no progress")
        yield process
    finally:
        for pid in [process.pid, *descendants(process.pid)]:
            if alive(pid):
                os.kill(pid, signal.SIGKILL)
        process.wait()


def stored(folder: Path) -> int:
    """Number of finished chunks."""
    return len(list((folder / "a.run" / "shards").glob("*.h5")))


def assert_resumes_to(folder: Path, expected: bytes) -> None:
    """The same command goes on from what is stored and ends with the same dataset."""
    assert stored(folder) > 0
    done = subprocess.run(command(), cwd=folder, check=True, capture_output=True, text=True)
    assert ", 0 already stored" not in done.stderr
    assert (folder / "a.nc").read_bytes() == expected
    assert not list((folder / "a.run").glob(".beat-*"))


@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGKILL, -9), (signal.SIGTERM, 143), (signal.SIGINT, 130)],
)
def test_the_parent_ends(
    tmp_path: Path,
    undisturbed: bytes,
    running: subprocess.Popen[bytes],
    number: signal.Signals,
    code: int,
) -> None:
    family = descendants(running.pid)
    os.kill(running.pid, number)
    assert running.wait(PATIENCE) == code
    wait_for(lambda: not any(map(alive, family)), "a process stayed behind")
    assert not (tmp_path / "a.nc").exists()
    assert_resumes_to(tmp_path, undisturbed)


def test_ctrl_c_in_a_terminal_reaches_all_at_once(
    tmp_path: Path, undisturbed: bytes, running: subprocess.Popen[bytes]
) -> None:
    family = descendants(running.pid)
    os.killpg(running.pid, signal.SIGINT)
    assert running.wait(PATIENCE) == 130
    wait_for(lambda: not any(map(alive, family)), "a process stayed behind")
    assert_resumes_to(tmp_path, undisturbed)


def test_a_killed_worker_is_replaced(
    tmp_path: Path, undisturbed: bytes, running: subprocess.Popen[bytes]
) -> None:
    os.kill(workers_of(running.pid)[0], signal.SIGKILL)
    assert running.wait(PATIENCE) == 0
    assert (tmp_path / "a.nc").read_bytes() == undisturbed
    assert "a worker died" in (tmp_path / "a.run" / "run.log").read_text()


def test_a_second_run_is_refused_while_the_first_is_alive(
    tmp_path: Path, running: subprocess.Popen[bytes]
) -> None:
    os.kill(running.pid, signal.SIGSTOP)  # alive, but it will not end meanwhile
    second = subprocess.run(command(), cwd=tmp_path, capture_output=True, text=True)
    assert second.returncode == 7
    assert str(running.pid) in second.stderr
