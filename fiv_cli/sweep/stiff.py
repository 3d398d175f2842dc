"""Laws that will cost far more steps than Coulomb's: said before the run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from fiv_cli.analyses import get_analysis
from fiv_cli.analyses.base import Request
from fiv_cli.analyses.execute import cost_of_law
from fiv_cli.models import get_model
from fiv_cli.sweep.plan import AnalysisPlan
from fiv_cli.sweep.requests import request_at

DEAR = 100.0  # times the steps of Coulomb's law
MOST = 1e9  # what is more is said to be so much
LOOKED_AT = 16  # points of an analysis, spread evenly


def stiff_laws(
    analyses: Iterable[AnalysisPlan], announce: Callable[[str], None] = lambda sentence: None
) -> list[str]:
    """A sentence for each law of the analyses that is dear somewhere, with where it is dearest.

    `announce` is told when code must be generated or compiled.
    """
    dearest: dict[str, tuple[float, str]] = {}
    for analysis in analyses:
        for law, cost, sentence in _costs(analysis, announce):
            if cost > dearest.get(law, (DEAR, ""))[0]:
                dearest[law] = cost, sentence
    return [sentence for _, sentence in dearest.values()]


def _costs(
    analysis: AnalysisPlan, announce: Callable[[str], None]
) -> Iterator[tuple[str, float, str]]:
    """(law, its steps in Coulomb's, a sentence) of each law that may be stiff."""
    for requests in _alike(analysis).values():
        setup = next(iter(requests.values())).setup
        points = [request.parameters for request in requests.values()]
        cost = cost_of_law(setup, points, announce)
        both = np.nan_to_num(np.maximum(*cost), nan=0.0, posinf=np.inf)
        worst = int(np.argmax(both))
        times, where = both[worst], list(requests)[worst]
        resting = bool(cost.resting[worst] > cost.sliding[worst])
        amount, when = ("up to", ", while a contact nearly rests") if resting else ("some", "")
        yield (
            setup.law.name,
            float(times),
            f"{setup.law.name} is stiff: {amount} {_roughly(times)} times the steps of "
            f"coulomb{when} (at {where})",
        )


def _roughly(times: float) -> str:
    """One digit: ``3,000``."""
    return f"{float(f'{min(times, MOST):.1g}'):,.0f}"


def _alike(analysis: AnalysisPlan) -> dict[object, dict[str, Request]]:
    """Points whose law is smooth or has states, by system: how they are named, and their runs."""
    found: dict[object, dict[str, Request]] = {}
    template = analysis.template
    is_motion = get_analysis(template.analysis).generated and not template.linear
    if not is_motion or not get_model(template.model).contacts:
        return found
    spread = np.unique(np.linspace(0, analysis.size - 1, LOOKED_AT).round().astype(np.int64))
    for position, (values, _) in zip(spread.tolist(), analysis.points(spread), strict=True):
        request = request_at(template, values, None)
        if request.setup.law.kind != "set-valued":
            found.setdefault(request.setup.key, {})[analysis.named(position)] = request
    return found
