"""How many points of response analyses have no class, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from fiv_cli.reading.datasets import class_names

if TYPE_CHECKING:
    import xarray as xr


@dataclass
class Undecided:
    """Counts over datasets.

    Attributes
    ----------
    points : points that were asked for their class (not: not computed, not reached)
    reasons : reason -> undecided points
    """

    points: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    def add(self, analyses: Iterable[xr.Dataset]) -> None:
        """Count the points of analyses that tell a class."""
        for dataset in analyses:
            if "attractor" in dataset and "reason" in dataset:
                names, reasons = map(class_names, (dataset["attractor"], dataset["reason"]))
                self.points += int(np.sum(names != "not_computed"))
                self.reasons.update(reasons[names == "undecided"].tolist())

    @property
    def total(self) -> int:
        """Undecided points."""
        return sum(self.reasons.values())

    def as_plain(self) -> Mapping[str, object]:
        """For ``--json``."""
        return {"points": self.points, "undecided": self.total, "reasons": dict(self.reasons)}

    def line(self) -> str:
        """``undecided: 30 of 8,040 points (0.37 %): time_budget 22, tests_disagree 8``."""
        share = 100.0 * self.total / self.points if self.points else 0.0
        listed = ", ".join(f"{name} {count}" for name, count in self.reasons.most_common())
        text = f"undecided: {self.total:,} of {self.points:,} points ({float(f'{share:.2g}'):g} %)"
        return f"{text}: {listed}" if listed else text
