"""Figures from datasets: ``draw(dataset, figure)``; one file per kind of figure.

To add a kind: write ``fiv_cli/plots/my_kind.py`` with ``suits(dataset) -> bool`` (whether it can
be drawn from this dataset) and ``draw(layers, settings) -> Figure``, and list it in
``fiv_cli/plots/drawing.py``. A figure is made from the dataset alone, never from live objects.
"""

from __future__ import annotations

from fiv_cli.plots.drawing import (
    can_draw,
    default_figures,
    draw,
    figures_called,
    figures_of,
    nothing_suits,
    possible_figures,
)
from fiv_cli.plots.law import draw_laws
from fiv_cli.plots.saving import save
from fiv_cli.plots.style import LOOKS, Look, look_of

__all__ = [
    "LOOKS",
    "Look",
    "can_draw",
    "default_figures",
    "draw",
    "draw_laws",
    "figures_called",
    "figures_of",
    "look_of",
    "nothing_suits",
    "possible_figures",
    "save",
]
