"""Every shipped class asked again, with twice the time and a tenth of the tolerance.

    python -m tests.asked_again FOLDER [CASE...] [--workers N]

Cases of chapters with an analysis `response`, or those named by their stem, are run as shipped
and once more with twice the `t_max` (and twice the events and steps), at a tenth of `rtol`. One
line per case says how many points have a class before and after, and how many have another one
now; those are listed. What is finished in FOLDER is kept: the same command goes on where it was
stopped. The exit code is 1 where a class changed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fiv_cli.case.case import Case
from fiv_cli.case.load import load_case
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.reading.datasets import flag_names
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.run import run_case

CONFIGS = Path(__file__).parents[1] / "configs"
MORE, TIGHTER = 2, 0.1
OPEN = ("undecided", "not_computed", "")  # no class


def cases(stems: Sequence[str] = ()) -> list[Path]:
    """The cases of chapters with an analysis `response`, or those of them that are named."""
    paths = sorted(CONFIGS.glob("ch*/*.toml"))
    asked = [path for path in paths if not stems or path.stem in stems]
    return [path for path in asked if responses(load_case(path))]


def responses(case: Case) -> list[int]:
    """Numbers of the analyses `response` of a case."""
    return [n for n, analysis in enumerate(case.analyses) if analysis.kind == "response"]


def harder(case: Case) -> tuple[str, ...]:
    """The overrides that ask a case again."""
    times = [
        f"analysis.{n}.t_max={MORE * case.analyses[n].settings['t_max']!r}" for n in responses(case)
    ]
    solver = case.solver
    return (
        *times,
        f"solver.rtol={TIGHTER * solver.rtol!r}",
        f"solver.max_events={MORE * solver.max_events}",
        f"solver.max_steps={MORE * solver.max_steps}",
    )


@dataclass(frozen=True)
class Answers:
    """Classes of an analysis, point by point."""

    dims: tuple[str, ...]
    coords: dict[str, NDArray]
    classes: NDArray

    @property
    def decided(self) -> NDArray[np.bool_]:
        """Where there is a class."""
        return ~np.isin(self.classes, OPEN)

    def place(self, index: Sequence[int]) -> str:
        """A point by its coordinates."""
        pairs = zip(self.dims, index, strict=True)
        return ", ".join(f"{dim} = {self.coords[dim][n]}" for dim, n in pairs)


def answers(dataset: xr.Dataset) -> Answers:
    """The classes in a dataset of `response`."""
    told = dataset["attractor"]
    names = flag_names(told.attrs)
    classes = [names.get(int(code), "") for code in told.values.ravel()]
    dims = tuple(map(str, told.dims))
    coords = {d: dataset[d].values if d in dataset else np.arange(dataset.sizes[d]) for d in dims}
    return Answers(dims, coords, np.array(classes, dtype=object).reshape(told.shape))


def changes(before: Answers, after: Answers) -> Iterator[str]:
    """Every point that had a class and has another one."""
    differ = before.decided & after.decided & (before.classes != after.classes)
    for index in np.argwhere(differ):
        was, now = before.classes[tuple(index)], after.classes[tuple(index)]
        yield f"{before.place(index)}: {was} -> {now}"


def compared(name: str, before: Answers, after: Answers) -> tuple[str, list[str]]:
    """The line of a case, and its changed points."""
    found = list(changes(before, after))
    decided = f"{np.sum(before.decided)} -> {np.sum(after.decided)}"
    line = f"{name}: {before.classes.size} points, decided {decided}, changed {len(found)}"
    return line, found


def ask(path: Path, folder: Path, workers: int) -> Iterator[tuple[str, list[str]]]:
    """Run a case twice, and compare each `response` of it."""
    case = load_case(path)
    runs = {}
    for name, overrides in (("shipped", ()), ("again", harder(case))):
        output = folder / name / f"{path.stem}.nc"
        output.parent.mkdir(parents=True, exist_ok=True)
        run_case(load_case(path, overrides), output, Policy(workers=workers), Silent())
        runs[name] = read_datasets(output)
    for name, dataset in runs["shipped"].items():
        if "attractor" in dataset:
            label = f"{path.stem} {name}".strip()
            yield compared(label, answers(dataset), answers(runs["again"][name]))


def main(arguments: Sequence[str]) -> int:
    """Ask, print, and say whether a class changed."""
    parser = argparse.ArgumentParser("python -m tests.asked_again")
    parser.add_argument("folder", type=Path)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args(arguments)
    unknown = set(given.cases) - {path.stem for path in cases(given.cases)}
    if unknown:
        parser.error(f"no case with an analysis response: {', '.join(sorted(unknown))}")
    total = 0
    for path in cases(given.cases):
        for line, changed in ask(path, given.folder, given.workers):
            print("\n    ".join([line, *changed]), flush=True)
            total += len(changed)
    print(f"{total} classes changed")
    return int(total > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
