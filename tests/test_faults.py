"""The faults that attacks on 0.1.0 found, by their numbers there; each of these tests fails on it.

They know nothing of fiv but its command line, so that they can be run against another version:
with its Python, its folder in PYTHONPATH, and its program as FIV_UNDER_TEST. Faults 1, 3, 4 and 19
have theirs in ``test_signals.py``, 10 in ``test_journal_damage.py``, 20 in ``test_kill.py``, which
passes wherever it is started.
"""

from __future__ import annotations

import ast
import ctypes
import os
import resource
import struct
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from disturbed import Run, by_default
from small_cases import PIN as CASE

import fiv_cli
from fiv_cli.cli.main import run as fiv

EXTREME = """
schema = 1
[model]
name = "{model}"
{settings}
[grid]
{axis}
[[analysis]]
kind = "{analysis}"
"""
EXTREMES = {
    "hole_too_small": EXTREME.format(
        model="annular-plate",
        settings="parameters = { a = 1e-9 }\noptions = { modes = [[0, 1]] }",
        axis="h = [2e-3]",
        analysis="plate",
    ),
    "inexact_equilibrium": EXTREME.format(
        model="belt-5dof",
        settings="parameters = { M = 1.78e-6, m = 3.647e-12, k1 = 1.215e-4, k5 = 9.2e6, "
        "k_nl = 3.3e9, l2 = 24.8 }",
        axis="mu_k = [0.3]",
        analysis="equilibrium",
    ),
}
SLOW_BELT = """
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [1e-12]
[[initial]]
label = "sticking"
kind = "state"
state = { x = 0.0, x_dot = "v" }
[[analysis]]
kind = "response"
transient = 20.0
t_max = 200.0
"""
ZIPPED = """
schema = 1
[model]
name = "flutter-2dof"
[sweep]
zip = [["k1", "mu_k"]]
[grid]
k1 = [1.0, 1.0, 1.0, 1.0]
mu_k = [4.0, 4.1, 4.4, 4.5]
[[analysis]]
kind = "eigenvalues"
"""
FIGURES = """
title = "broken $\\\\mu_k^$"
schema = 1
[model]
name = "pin-on-disc"
[grid]
"friction.mu_k" = [0.2, 0.3]
N0 = [10.0, 20.0]
[[analysis]]
kind = "equilibrium"
[[figure]]
kind = "curve"
x = "N0"
variable = "n_solutions"
"""
STRIKE = """
import netCDF4, os, signal, weakref

struck = []

def strike(reference=None):
    if not struck:
        struck.append(True)
        os.kill(os.getpid(), signal.SIGTERM)
        for _ in range(100_000):  # Python calls the handler in here
            pass
"""
IN_A_CALLBACK = f"""{STRIKE}
class Thing:
    pass

class Struck(netCDF4.Dataset):
    def createVariable(self, *arguments, **named):
        thing = Thing()
        reference = weakref.ref(thing, strike)
        del thing
        return super().createVariable(*arguments, **named)

netCDF4.Dataset = Struck
"""
IN_A_FILE = f"""{STRIKE}
class Struck(netCDF4.Dataset):
    def createVariable(self, *arguments, **named):
        strike()
        return super().createVariable(*arguments, **named)

netCDF4.Dataset = Struck
"""
INOTIFY_OPEN = 0x20
INOTIFY_EVENT = struct.Struct("iIII")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a case in it."""
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(CASE)
    return tmp_path


def run(*options: str) -> int:
    """Exit code of a run into ``a.nc``."""
    return fiv(["run", "a.toml", "-o", "a.nc", "--workers", "1", "-q", *options])


def run_anew(folder: Path, **named: Any) -> None:
    """A run in a process of its own, which has no code in memory yet."""
    with Run(("run", "a.toml", "-o", "a.nc", "--workers", "1", "--fresh"), folder, **named) as new:
        assert new.code() == 0, new.said


@contextmanager
def opened(folder: Path) -> Iterator[Counter[str]]:
    """How often each file of a folder is opened meanwhile; known afterwards."""
    counts: Counter[str] = Counter()
    system = ctypes.CDLL(None)
    watch = system.inotify_init1(os.O_NONBLOCK)
    assert system.inotify_add_watch(watch, os.fsencode(folder), INOTIFY_OPEN) > 0
    try:
        yield counts
        with pytest.raises(BlockingIOError):
            while events := os.read(watch, 1 << 16):
                counts.update(_names(events))
    finally:
        os.close(watch)


def _names(events: bytes) -> Iterator[str]:
    """Names of the files that a series of events is about."""
    at = 0
    while at < len(events):
        *_, length = INOTIFY_EVENT.unpack_from(events, at)
        at += INOTIFY_EVENT.size
        yield os.fsdecode(events[at : at + length].rstrip(b"\0"))
        at += length


# --- 5: damaged datasets --------------------------------------------------------------------------
def unpaired_classes(file: h5py.File) -> None:
    file["status"].attrs["flag_meanings"] = "ok"


def reason_away(file: h5py.File) -> None:
    del file["reason"]


def numbers_called_text(file: h5py.File) -> None:
    file.create_dataset("note", data=np.uint64(3)).attrs["_Encoding"] = "utf-8"


@pytest.mark.parametrize("damage", [unpaired_classes, reason_away, numbers_called_text])
@pytest.mark.parametrize("command", [["show"], ["diff", "a.nc"]], ids=lambda words: words[0])
def test_5_a_damaged_dataset_is_told(
    command: list[str], damage: Callable[[h5py.File], None], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run() == 0
    with h5py.File("a.nc", "r+") as file:
        damage(file)
    assert fiv([*command, "a.nc"]) == 3
    assert "a.nc: " in capsys.readouterr().err


# --- 6, 7, 9: what is let in ----------------------------------------------------------------------
def test_6_a_link_that_lies_in_wait_is_not_written_through(here: Path) -> None:
    (here / "victim").write_text("kept")
    (here / ".a.nc.tmp").symlink_to("victim")
    assert run() == 0
    assert (here / "victim").read_bytes() == b"kept"


def test_7_code_is_kept_where_only_its_user_writes(here: Path, own_cache: Path) -> None:
    run_anew(here, entry=lambda: [by_default(), os.umask(0)])
    assert not any(path.stat().st_mode & 0o077 for path in (own_cache, *own_cache.iterdir()))


def test_7_code_that_others_may_have_written_is_not_loaded(here: Path, own_cache: Path) -> None:
    run_anew(here)
    own_cache.chmod(0o777)
    with opened(own_cache) as files:
        run_anew(here)
    assert not files


def test_9_a_pipe_is_not_waited_for(here: Path) -> None:
    os.mkfifo(here / "a.nc")
    with Run(("run", "a.toml", "-o", "a.nc"), here) as refused:
        assert refused.code() == 2


# --- 8, 11, 16: cases -----------------------------------------------------------------------------
def test_8_a_title_of_broken_mathematics_is_drawn() -> None:
    Path("a.toml").write_text(FIGURES + "select = { mu_k = 0.3 }")
    assert run() == 0
    assert fiv(["plot", "a.nc"]) == 0


def modest() -> None:
    """In the child: no more than any `check` may take."""
    resource.setrlimit(resource.RLIMIT_CPU, (10, 10))
    resource.setrlimit(resource.RLIMIT_DATA, (2**30, 2**30))


LARGE = {
    "dotted keys": "a" + ".a" * 20_000 + " = 1",
    "nested lists": "a = [" + "[[[[1]]]], " * 10**6 + "]",
}


@pytest.mark.parametrize("text", LARGE.values(), ids=LARGE)
def test_11_a_case_of_another_size_costs_nothing(here: Path, text: str) -> None:
    Path("a.toml").write_text(text)
    with Run(("check", "a.toml"), here, entry=modest) as checked:
        assert checked.code() == 3


def test_11_keys_do_not_steer_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a.toml").write_text('"\\u0007\\u202e" = 1\n' + CASE)
    assert fiv(["check", "a.toml"]) == 3
    said = capsys.readouterr().err
    assert "\\x07\\u202e" in said
    assert said.replace("\n", "").isprintable()


def test_16_what_a_case_asks_to_be_drawn_is_read_once(capsys: pytest.CaptureFixture[str]) -> None:
    """A quoted key passed `check` and `run`; what `--set` says reaches `plot`."""
    Path("a.toml").write_text(FIGURES + 'select = { "friction.mu_k" = 0.3 }')
    assert run("--set", 'figure.0.variable="residual"') == 0
    assert fiv(["plot", "a.nc"]) == 0
    capsys.readouterr()
    assert run("--set", 'figure.0.name="as set"') == 0
    assert fiv(["plot", "a.nc"]) == 0
    assert "as set" in capsys.readouterr().out


# --- 12, 15: assembling ---------------------------------------------------------------------------
def grouped(count: int) -> str:
    """A case of so many analyses."""
    return CASE + "".join(
        f'name = "a{i}"\n[[analysis]]\nkind = "equilibrium"\n' for i in range(count)
    )


def written() -> int:
    """Bytes that this process has written so far."""
    counts = dict(line.split(": ") for line in Path("/proc/self/io").read_text().splitlines())
    return int(counts["wchar"])


def test_12_a_dataset_of_many_analyses_is_written_once() -> None:
    """Not once more, in effect, with each of them: twenty wrote ninety times their size."""
    Path("a.toml").write_text(grouped(20))
    before = written()
    assert run() == 0
    assert written() - before < 5 * Path("a.nc").stat().st_size


@pytest.mark.parametrize("place", [IN_A_FILE, IN_A_CALLBACK], ids=["2 file", "15 callback"])
def test_2_15_a_signal_lets_the_writing_end_wherever_it_strikes(here: Path, place: str) -> None:
    """An exception there: the file stayed locked, and no exception leaves a callback."""
    (here / "sitecustomize.py").write_text(place)
    first = {"PYTHONPATH": f"{here}:{os.environ.get('PYTHONPATH', '')}"}
    with Run(("run", "a.toml", "-o", "a.nc", "--workers", "1"), here, first) as struck:
        assert struck.code() == 143
    assert struck.said.endswith("terminated: a.nc is whole\n") and "Traceback" not in struck.said
    with xr.open_dataset("a.nc") as found:
        assert "partial" not in found.attrs


# --- 13, 14: answers ------------------------------------------------------------------------------
@pytest.mark.parametrize("reason", EXTREMES)
def test_13_an_extreme_point_fails_for_a_reason_of_its_own(reason: str) -> None:
    Path("a.toml").write_text(EXTREMES[reason])
    assert run() == 4
    with xr.open_dataset("a.nc") as found:
        names = found["reason"].attrs["flag_meanings"].split()
        assert names[found["reason"].values.item()] == reason


def test_13_an_exponent_is_finite_or_missing() -> None:
    Path("a.toml").write_text(SLOW_BELT)
    assert run() == 0
    with xr.open_dataset("a.nc") as found:
        assert not np.isinf(found["lyapunov"].values).any()


def test_14_eigenvalues_along_axes_without_order_are_kept() -> None:
    Path("a.toml").write_text(ZIPPED)
    assert run() == 0
    with xr.open_dataset("a.nc") as found:
        assert np.isfinite(found["growth_rate"].values).all()


# --- 17, 18: compiled code ------------------------------------------------------------------------
def test_17_no_check_is_an_assert() -> None:
    """They tell the type checker what is known; under ``python -O`` nothing is lost."""
    asserts = [
        f"{path.name}: {ast.unparse(node.test)}"
        for path in Path(fiv_cli.__file__).parent.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Assert) and not narrows(node.test)
    ]
    assert asserts == []


def narrows(test: ast.expr) -> bool:
    """Whether it says ``... is not None`` or ``isinstance(...)``."""
    if isinstance(test, ast.BoolOp):
        return all(map(narrows, test.values))
    return ast.unparse(test).startswith("isinstance(") or ast.unparse(test).endswith("is not None")


def test_18_nothing_is_written_to_see_whether_there_is_room(here: Path, own_cache: Path) -> None:
    run_anew(here)
    with opened(own_cache) as files:
        run_anew(here)
    assert set(files) <= {path.name for path in own_cache.iterdir()}


def test_18_code_that_nobody_uses_goes(here: Path, own_cache: Path) -> None:
    own_cache.mkdir(0o700)
    (own_cache / "old").touch()
    os.utime(own_cache / "old", (0.0, time.time() - 100 * 86400.0))
    run_anew(here)
    assert "old" not in {path.name for path in own_cache.iterdir()}
