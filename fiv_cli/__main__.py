"""The console script, ``python -m fiv_cli``: signals first, then all that there is to import."""

from __future__ import annotations

from typing import NoReturn

from fiv_cli import ending


def main() -> NoReturn:
    """Carry out the command line."""
    ending.take_over()
    from fiv_cli.cli.main import main as carry_out

    carry_out()


if __name__ == "__main__":
    main()
