"""What is told of failed points while a run goes on: the first at once, and that all fail alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fiv_cli.data.block import Block
from fiv_cli.flags import REASONS, STATUS

FAILED = STATUS.codes["failed"]

MANY = 20
"""Points after which it is no accident that all of them fail alike."""


@dataclass
class Failures:
    """Follows a run.

    Attributes
    ----------
    tell : writes a line for whoever watches
    run, failed : points so far
    reason : of the first that failed
    alike : whether every point has failed for this reason
    """

    tell: Callable[[str], None]
    run: int = 0
    failed: int = 0
    reason: int = 0
    alike: bool = True

    def note(self, block: Block, named: Callable[[int], str]) -> None:
        """Take finished points into account; `named` says where a row lies."""
        rows = np.flatnonzero(block.status == FAILED)
        if len(rows) and not self.failed:
            self.reason = int(block.reason[rows[0]])
            what = explained(self.reason, block.messages.get(int(rows[0]), ""))
            self.tell(f"a point failed, {named(int(rows[0]))}: {what}")
        few = self.run < MANY
        self.run, self.failed = self.run + len(block), self.failed + len(rows)
        reasons = block.reason[rows]
        self.alike &= len(rows) == len(block) and bool((reasons == self.reason).all())
        if self.alike and few and self.run >= MANY:
            reason = REASONS[self.reason]
            told = f"all {self.run} points until now failed for one reason, {reason.name}"
            self.tell(f"{told}: {reason.advice}. Ctrl-C ends the run")


def explained(code: int, message: str) -> str:
    """Why a point failed: its own words, or what the table of reasons says."""
    reason = REASONS[code]
    return message.partition("\n")[0] or f"{reason.name}: {reason.advice}"
