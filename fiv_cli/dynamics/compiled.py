"""The compiled driver: once per user, on first use, anew after any edit of its files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fiv_cli.codegen import codes
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.dynamics import kernel, roots

FOLDER = Path(__file__).parent
SIGNATURE = "int64(int64, float64, float64, boolean)"


def run_at(address: int) -> kernel.Run:
    """The run whose frame is at an address."""
    return kernel.Run.at(address)


def advance_at(address: int, t_stop: float, phase_interval: float, measuring: bool) -> int:
    """`kernel.advance` of the run at an address."""
    return kernel_advance(run_at(address), t_stop, phase_interval, measuring)


kernel_advance = kernel.advance  # numba reads no functions off modules


def _declare() -> Callable[..., int]:
    from fiv_cli.codegen.kernels import register, register_frame

    register_frame(kernel.Run, run_at)
    register(roots)
    register(kernel)
    return advance_at


FILES = (
    *(FOLDER / name for name in ("kernel.py", "roots.py", "compiled.py")),
    Path(codes.__file__),
)
DRIVER = Compiled("driver", SIGNATURE, FILES, _declare)


def load_driver(announce: Callable[[str], None]) -> None:
    """Have the driver at hand; `announce` is called with a sentence if it must be compiled."""
    told = (
        "compiling the integrator (once per user: half a minute on a free core, minutes on a busy "
        "machine; ended before it is done, it begins anew)"
    )
    DRIVER.load(announce, told)
