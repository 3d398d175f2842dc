"""A signal whose exception is lost ends the program all the same."""

from __future__ import annotations

import subprocess
import sys

import pytest

LOST = """
import os, signal
from fiv_cli import ending
from fiv_cli.cli.main import {handler}

class Finalised:
    def __del__(self):
        os.kill(os.getpid(), {number})
        for _ in range(1000):
            pass

signal.signal({number}, {handler})
Finalised()
print("lost", flush=True)
ending.heed()
print("went on")
"""


@pytest.mark.parametrize(
    ("number", "handler", "code"),
    [("signal.SIGTERM", "_terminate", 143), ("signal.SIGINT", "_interrupt", -2)],
)
def test_what_is_lost_in_a_finalizer_is_heeded(number: str, handler: str, code: int) -> None:
    text = LOST.format(number=number, handler=handler)
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
    assert done.stdout == "lost\n"
    assert done.returncode == code
