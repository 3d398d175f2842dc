"""What the tables of the linear analyses share."""

from __future__ import annotations

from fiv_cli.analyses.base import Setting

SYSTEM = Setting(
    "system",
    "string",
    "original",
    "without its excitation, or averaged over it (thesis 5.7-5.15)",
    choices=("original", "averaged"),
)
