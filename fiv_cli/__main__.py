"""The console script, ``python -m fiv_cli``: signals first, then all that there is to import."""

from __future__ import annotations

import gc
import os
from typing import NoReturn

from fiv_cli import ending

RARELY = 50_000
"""New objects between two searches for garbage: of the many that an import makes, all stay."""


def main() -> NoReturn:
    """Carry out the command line."""
    ending.take_over()
    gc.set_threshold(RARELY)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small: threads only wait
    from fiv_cli.cli.main import main as carry_out

    carry_out()


if __name__ == "__main__":
    main()
