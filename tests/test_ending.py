"""A signal ends the program wherever it strikes; no exception is raised there."""

from __future__ import annotations

import subprocess
import sys

import pytest
from disturbed import by_default

from fiv_cli import ending

STRUCK = """
import os, signal, time
from fiv_cli import ending
ending.take_over()

class Finalised:
    def __del__(self):
        os.kill(os.getpid(), {number})
        for _ in range(1000):
            pass

"""
AT_ONCE = STRUCK + "Finalised()\ntime.sleep(60.0)"
HEEDED = (
    STRUCK
    + """
ending.PATIENCE = 1.0
with ending.last_act(lambda: print("last act", flush=True)):
    try:
        with ending.heeded():
            Finalised()
            os.kill(os.getpid(), {number})  # an echo
            print("goes on", flush=True)
            ending.heed()
            print("went on")
    except ending.Ended:
        time.sleep(1.2)
        print("puts in order", flush=True)
    ending.finish()
"""
)
STUBBORN = (
    STRUCK
    + """
ending.PATIENCE = 60.0
with ending.heeded():
    Finalised()
    time.sleep(2.0 * ending.ECHO)
    os.kill(os.getpid(), {number})
    time.sleep(60.0)
"""
)
ENDS = [("signal.SIGINT", 130), ("signal.SIGTERM", 143), ("signal.SIGHUP", 129)]


def outcome(program: str, number: str) -> subprocess.CompletedProcess[str]:
    """What becomes of a program to which a signal comes in a finalizer."""
    return subprocess.run(
        [sys.executable, "-c", program.format(number=number)],
        capture_output=True,
        text=True,
        timeout=30.0,
        preexec_fn=by_default,
    )


@pytest.mark.parametrize(("number", "code"), ENDS)
def test_at_once_where_nothing_is_to_be_put_in_order(number: str, code: int) -> None:
    done = outcome(AT_ONCE, number)
    assert (done.returncode, done.stdout) == (code, "")
    assert done.stderr.strip() in ending.NAMES.values()


@pytest.mark.parametrize(("number", "code"), ENDS)
def test_at_a_safe_point_where_there_is_one(number: str, code: int) -> None:
    done = outcome(HEEDED, number)
    assert done.returncode == code
    assert done.stdout.splitlines() == ["goes on", "puts in order", "last act"]


@pytest.mark.parametrize(("number", "code"), ENDS)
def test_a_second_signal_waits_for_nothing(number: str, code: int) -> None:
    assert outcome(STUBBORN, number).returncode == code


def test_nothing_is_heeded_where_nothing_came() -> None:
    with ending.heeded():
        ending.heed()
