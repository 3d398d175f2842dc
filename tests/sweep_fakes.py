"""Stand-ins for the physics: executors that are quick, exact, and fail on demand."""

from __future__ import annotations

import os
import struct
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from fiv_cli.analyses.base import Outcome, Request
from fiv_cli.case.case import Case
from fiv_cli.case.load import parse_case

CLASSES = ("periodic", "chaotic", "equilibrium")

BELT = """
schema = 1
title = "fake sweep"
[model]
name = "belt-1dof"
[grid]
N = { start = 1, stop = 5, num = 5 }
v = [0.5, 1.0, 2.0]
[[initial]]
label = "near"
kind = "equilibrium"
offset = { x = 1e-4 }
[[initial]]
label = "far"
kind = "state"
state = { x_dot = "v" }
[[analysis]]
kind = "response"
"""

CHAIN = """
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [0.5, 1.0]
N = { start = 1, stop = 8, num = 8 }
[[initial]]
label = "far"
kind = "state"
state = { x = 1.0 }
[[initial]]
label = "up"
kind = "continue"
along = "N"
direction = "up"
from = "far"
[[analysis]]
kind = "response"
"""

LOOP = CHAIN.replace(
    'from = "far"\n',
    """from = "far"
on_loss = "go-on"
[[initial]]
label = "down"
kind = "continue"
along = "N"
direction = "down"
from = "up"
on_loss = "go-on"
""",
)
"""Up, and down again from where it ended."""


def case(text: str = BELT, *overrides: str) -> Case:
    """A case from TOML text."""
    return parse_case(text, "fake.toml", overrides)


def prepare(requests: Iterable[Request], announce: Callable[[str], None]) -> None:
    """Nothing has to be compiled; the requests must be sound all the same."""
    assert all(request.setup for request in requests)


def answer(request: Request) -> Outcome:
    """A response that depends on every input, irrational enough to notice any change of a bit."""
    p = request.parameters
    start = request.start
    carried = 0.0 if start is None or start.carried is None else start.carried["x"]
    offset = 0.0 if start is None else sum(start.values.values())
    x = float(np.sin(p["N"] * 1.7 + p["v"]) + 0.3 * offset + 0.1 * carried)
    count = int(p["N"]) % 4
    return Outcome(
        values={
            "attractor": CLASSES[int(p["N"] > 6)],
            "L_s": x * x,
            "L_s_reference": np.array([x]),
            "multiplicity": count,
            "stick_fraction": abs(x) / 2,
            "floquet_multiplier": np.array([x, x / 3])[: count % 2 + 1],
        },
        ragged={"section_value": np.sin(np.arange(count) + x)},
        carry={"x": x, "state": np.array([x, 2 * x])},
    )


MOTIONS: list[Request] = []
"""Requests for a motion that `motion` was asked."""


def motion(request: Request) -> Outcome:
    """A motion of three samples, or `answer` where no motion is asked for."""
    if request.analysis != "history":
        return answer(request)
    MOTIONS.append(request)
    time = np.linspace(0.0, 1.0, 3)
    return Outcome(values={"time": time, "x": time})


def counted(request: Request) -> Outcome:
    """`answer`, leaving one line per run in the file that FIV_TEST_COUNT names."""
    with Path(os.environ["FIV_TEST_COUNT"]).open("a") as file:
        file.write(f"{request.parameters['N']!r} {request.parameters['v']!r}\n")
    return answer(request)


def slippery(request: Request) -> Outcome:
    """`answer`, on a branch up to FIV_TEST_END that a step longer than 0.3 falls off."""
    outcome, N, start = answer(request), request.parameters["N"], request.start
    carried = {"N": N} if start is None or start.carried is None else start.carried
    on_it = abs(N - carried["N"]) <= 0.3 and float(os.environ["FIV_TEST_END"]) >= N
    outcome.values["attractor"] = "periodic" if on_it else "equilibrium"
    outcome.carry = {"N": N, "x": outcome.values["L_s"]}
    return outcome


def turning(request: Request) -> Outcome:
    """`answer`, of another class on the way down."""
    outcome, start = answer(request), request.start
    down = start is not None and start.label == "down"
    outcome.values["attractor"] = "equilibrium" if down else "periodic"
    return outcome


def slipping(request: Request) -> Outcome:
    """`motion` of what `slippery` answers."""
    return motion(request) if request.analysis == "history" else slippery(request)


def hazy(request: Request) -> Outcome:
    """`answer`, which cannot be told where N is 1, 4 or 5; there the motion goes on."""
    outcome = answer(request)
    if request.parameters["N"] in (1.0, 4.0, 5.0):
        outcome.values["attractor"], outcome.reason = "undecided", "time_budget"
    return outcome


def ended(request: Request) -> Outcome:
    """`hazy`, and where N = 4 nothing is left to go on from."""
    outcome = hazy(request)
    if request.parameters["N"] == 4.0:
        outcome.carry = None
    return outcome


def slow(request: Request) -> Outcome:
    """`answer` after a tenth of a second."""
    time.sleep(0.1)
    return answer(request)


def deadly(request: Request) -> Outcome:
    """Ends its process where N = 3 and v = 1."""
    if request.parameters["N"] == 3.0 and request.parameters["v"] == 1.0:
        os.kill(os.getpid(), 9)
    return answer(request)


def deadly_once(request: Request) -> Outcome:
    """Ends its process where N = 3 and v = 1, the first time only."""
    mark = Path(os.environ["FIV_TEST_COUNT"])
    if request.parameters["N"] == 3.0 and request.parameters["v"] == 1.0 and not mark.exists():
        mark.write_text("died")
        os.kill(os.getpid(), 9)
    return answer(request)


def breaking_off(request: Request) -> Outcome:
    """Ends its process where N = 3 and v = 1, the first time only, in the midst of an answer."""
    mark = Path(os.environ["FIV_TEST_COUNT"])
    if request.parameters["N"] == 3.0 and request.parameters["v"] == 1.0 and not mark.exists():
        mark.write_text("died")
        frame = sys._getframe()
        while "result_queue" not in frame.f_locals and frame.f_back is not None:
            frame = frame.f_back
        answers = frame.f_locals["result_queue"]
        answers._wlock.acquire()
        begun = struct.pack("!i", 1000) + b"the first of a thousand bytes"
        os.write(answers._writer.fileno(), begun)
        os.kill(os.getpid(), 9)
    return answer(request)


def raising(request: Request) -> Outcome:
    """Raises where N = 2."""
    if request.parameters["N"] == 2.0:
        raise ValueError("N is two")
    return answer(request)


def endless(request: Request) -> Outcome:
    """Takes a minute where N = 2 and v = 1."""
    if request.parameters["N"] == 2.0 and request.parameters["v"] == 1.0:
        time.sleep(60.0)
    return answer(request)


def malformed(request: Request) -> Outcome:
    """Returns a variable that no table knows."""
    return Outcome(values={"no_such_variable": 1.0})


def cheap(request: Request) -> Outcome:
    """A full set of scalars in no time, for sweeps of a million points."""
    x = request.parameters["Omega"] * 0.5 + request.parameters["N0"]
    extremes = {
        f"{state}_{kind}": x
        for state in ("phi", "phi_dot", "theta", "theta_dot")
        for kind in ("min", "max", "rms")
    }
    return Outcome(
        values={"attractor": "periodic", "L_s": x, "period": 1.0 / x, "n_steps": 10, **extremes},
        ragged={"section_value": [x, x / 3.0]},
    )


def region(request: Request) -> Outcome:
    """Periodic within an ellipse of (N, v) that depends on the start, equilibrium outside."""
    p, start = request.parameters, request.start
    far = start is not None and start.kind == "state"
    inside = ((p["N"] - 4.0) / 3.0) ** 2 + ((p["v"] - 2.0) / (1.5 if far else 0.8)) ** 2 < 1.0
    return Outcome(values={"attractor": "periodic" if inside else "equilibrium", "L_s": p["N"]})


def region_counted(request: Request) -> Outcome:
    """`region`, leaving one line per run in the file that FIV_TEST_COUNT names."""
    with Path(os.environ["FIV_TEST_COUNT"]).open("a") as file:
        file.write(f"{request.parameters['N']!r} {request.parameters['v']!r}\n")
    return region(request)


def region_raising(request: Request) -> Outcome:
    """`region`, raising at one point of the border's neighbourhood."""
    if request.parameters["N"] == 7.0 and request.parameters["v"] == 2.0:
        raise ValueError("N is seven")
    return region(request)


def two_islands(request: Request) -> Outcome:
    """`region` with a small chaotic island that coarse points miss."""
    p = request.parameters
    island = abs(p["N"] - 1.5) < 0.4 and abs(p["v"] - 0.5) < 0.2
    return Outcome(values={"attractor": "chaotic"}) if island else region(request)


REFINED = (
    BELT.replace("fake sweep", "refined map")
    .replace("N = { start = 1, stop = 5, num = 5 }", "N = { start = 1, stop = 9, num = 9 }")
    .replace("v = [0.5, 1.0, 2.0]", "v = { start = 0.25, stop = 4.25, num = 5 }\n[sweep]")
    .replace("[sweep]", '[sweep]\nrefine = { levels = 3, of = "attractor" }')
)

FINEST = REFINED.replace("num = 5", "num = 9").replace("levels = 3", "levels = 7")
"""A lattice of 1025 x 1025 points."""

MILLION = """
schema = 1
[model]
name = "pin-on-disc"
[grid]
N0 = { start = 1, stop = 1000, num = 1000 }
Omega = { start = 1, stop = 1000, num = 1000 }
[[analysis]]
kind = "response"
"""
