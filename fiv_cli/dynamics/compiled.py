"""The compiled driver: once per user, on first use, anew after any edit of its files."""

from __future__ import annotations

from pathlib import Path

from fiv_cli.codegen.native import Library
from fiv_cli.dynamics import kernel

FOLDER = Path(__file__).parent
DRIVER = Library("driver", (FOLDER / "kernel.py", FOLDER / "roots.py"), (kernel.advance,))
