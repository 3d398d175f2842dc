"""The log of a run: what happened, with dates, and how far it came when."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

from fiv_cli.data.course import Course
from fiv_cli.files import append_line

RUN_SUFFIX = ".run"

_BEGUN = re.compile(r"(\S+) fiv \S+: (fiv run .*); (\d+) of (\d+) points done")
_DATED = re.compile(r"(\d{4}-\d\d-\d\dT\S+) ")
_CAME = re.compile(r"(\S+) ([^:]+): .*, (\d+) of (\d+) points done")


@dataclass(frozen=True)
class Told:
    """What the log says of a run.

    Attributes
    ----------
    command : that was given
    course : how far it came, by the clock
    last : when it was heard of last, s
    """

    command: str
    course: Course
    last: float = 0.0


def run_folder(output: Path) -> Path:
    """The run directory beside a dataset: ``STEM.run`` for ``STEM.nc``."""
    return output.with_suffix(RUN_SUFFIX)


def logger(folder: Path) -> Callable[[str], None]:
    """Append dated lines to the log; a full disk must not hide what the log is about."""

    def write(text: str) -> None:
        stamp = datetime.now().astimezone().isoformat(timespec="milliseconds")
        with suppress(OSError):
            append_line(folder / "run.log", f"{stamp} {text}")

    return write


def came(done: int, total: int) -> str:
    """How far a run is, as `runs_in` finds it in the log."""
    return f"{done} of {total} points done"


def runs_in(folder: Path) -> list[Told]:
    """The runs that the log in a run directory tells of, in their order."""
    runs: list[Told] = []
    with suppress(OSError, ValueError), (folder / "run.log").open(encoding="utf-8") as lines:
        for line in lines:
            if begun := _BEGUN.match(line):
                time, command, done, total = begun.groups()
                runs.append(Told(command, Course(int(total), [_seconds(time)], [int(done)])))
            elif runs and (found := _CAME.match(line)):
                time, name, done, total = found.groups()
                course, points = runs[-1].course, int(done) - runs[-1].course.done
                if not points:  # it begins: what was compiled before is no part of its pace
                    course.note(_seconds(time), 0)
                course.turn(name, 0)
                if points:
                    course.note(_seconds(time), points)
                course.total = int(total)
            if runs and (dated := _DATED.match(line)):
                runs[-1] = replace(runs[-1], last=_seconds(dated[1]))
    return runs


def _seconds(time: str) -> float:
    return datetime.fromisoformat(time).timestamp()
