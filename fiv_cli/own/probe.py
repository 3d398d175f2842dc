"""Files of models are looked at in a process of their own before they are run in this one.

There they are run and checked, each within a time limit: what does not come to an end is stopped
wherever it is, in compiled code too, and the line is told on which it was. What was found sound is
kept by its content in the user's cache, and is not looked at again.
"""

from __future__ import annotations

import faulthandler
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, TextIO

from fiv_cli import ending
from fiv_cli.codegen import NUMERICS_VERSION, cache
from fiv_cli.errors import FivError, ModelFileError, Problem
from fiv_cli.friction.base import Law
from fiv_cli.models.base import Model
from fiv_cli.models.origin import Origin
from fiv_cli.own.load import declared, know, read, use

LIMIT = 20.0
"""Seconds in which a file must have run."""

CHECKING = 6
"""So many times as long may the derivatives of its equations take."""

_PROGRAM = "from fiv_cli.own.probe import main; main()"


def use_files(paths: Iterable[Path]) -> None:
    """Know the models and laws of these files, and none of others.

    Raises
    ------
    UsageError, ModelFileError
        one cannot be read; something in it is wrong.
    """
    origins = read(paths)
    examine(origins)
    use(origins)


def examine(origins: Sequence[Origin], limit: float = LIMIT) -> None:
    """Look at files, unless they are known to be sound.

    Raises
    ------
    ModelFileError
        with everything that is wrong in the first in which something is, and that in the others.
    """
    stamp = f"{_key(origins)}.sound"
    if not origins or cache.read(stamp) is not None:
        return
    found = _answers(origins, limit).items()
    wrong = [(origins[number].path, problems) for number, problems in found if problems]
    if wrong:
        raise ModelFileError(*wrong[0], wrong[1:])
    cache.write(stamp, b"")


def _key(origins: Sequence[Origin]) -> str:
    package = Path(__file__).parent.parent
    parts = ("own", "codegen", "models", "friction", "notation")
    files = [file for part in parts for file in sorted((package / part).glob("*.py"))]
    texts = [text for origin in origins for text in (origin.text, origin.entry)]
    return cache.content_key([cache.source_of(*files), *texts, str(NUMERICS_VERSION), sys.version])


def _answers(origins: Sequence[Origin], limit: float) -> dict[int, list[Problem]]:
    """Number of a file -> what is wrong in it."""
    asked = json.dumps([asdict(origin) for origin in origins])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with (
        subprocess.Popen(
            [sys.executable, "-P", "-c", _PROGRAM, str(limit)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, env=environment,
        ) as child,
        ending.last_act(child.kill),
    ):  # fmt: skip
        answer, said = child.communicate(asked)
    found: dict[int, list[Problem]] = {}
    begun: int | None = 0
    for line in answer.splitlines():
        number, problems = json.loads(line)
        found[number] = [Problem(**fields) for fields in problems or ()]
        begun = number if problems is None else None
    return found if begun is None else {begun: [_stopped(origins[begun], said, limit)]}


def _stopped(origin: Origin, said: str, limit: float) -> Problem:
    """What is wrong in a file whose process ended without an answer: where it was is told last."""
    if "Timeout" not in said:
        last = said.strip().rpartition("\n")[2] or "without a word"
        return Problem("file", f"it ended the process that ran it: {last}")
    places = re.findall(rf'File "{re.escape(origin.path)}", line (\d+)', said)
    line = int(places[0]) if places else None
    message = (
        f"does not come to an end ({limit:g} s to run, {limit * CHECKING:g} for its equations)"
    )
    hint = "it was stopped on this line; declare only, and let fiv compute"
    return Problem("file", message, "", hint, line)


# --- in the process of its own --------------------------------------------------------------------
def main() -> None:
    """Answer for the files that stand on stdin: a line when one is begun, one with its problems.

    All are run before the first is checked: a model may name a law of another file. Where one could
    not be run, models are left: what they name may stand there.
    """
    limit, answers = float(sys.argv[1]), os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what a file prints is no answer
    origins = [Origin(**fields) for fields in json.load(sys.stdin)]

    def is_sound(number: int, step: Callable[[Origin], Sequence[Problem]], patience: float) -> bool:
        _say(answers, number, None)
        faulthandler.dump_traceback_later(patience, exit=True)
        found = step(origins[number])
        _say(answers, number, [asdict(problem) for problem in found])
        return not found

    each = range(len(origins))
    known = [number for number in each if is_sound(number, _run, limit)]
    kinds = (Model, Law) if len(known) == len(each) else (Law,)
    for number in known:
        is_sound(number, partial(_check, kinds), limit * CHECKING)


def _say(answers: TextIO, number: int, problems: list[dict[str, Any]] | None) -> None:
    print(json.dumps([number, problems]), file=answers, flush=True)


def _run(origin: Origin) -> Sequence[Problem]:
    try:
        know([origin])
    except ModelFileError as error:
        return error.problems
    except FivError as error:
        return [Problem("package", str(error).partition("\n")[0])]
    return ()


def _check(kinds: tuple[type, ...], origin: Origin) -> Sequence[Problem]:
    from fiv_cli.own.check import problems_of

    things = [thing for thing in declared(origin) if isinstance(thing, kinds)]
    return [problem for thing in things for problem in problems_of(thing, origin)]
