"""Where and how the hand-written kernels are compiled.

numba's cache does not notice an edit in a file that a cached function calls into. Its folder is
therefore named after the content of all kernel files: an edited engine never runs stale code.
"""

from __future__ import annotations

from pathlib import Path

import numba

from fiv_cli.codegen.cache import cache_root, content_key, source_of

KERNEL_FILES = ("call.py", "compiled.py", "kernel.py", "roots.py")

# Kernels own no arrays: without numba's reference counting (an atomic operation for each array at
# each call) they run twice as fast. Nothing calls them from C.
CACHE = {
    "cache": True,
    "error_model": "numpy",
    "fastmath": False,
    "_nrt": False,
    "no_cfunc_wrapper": True,
}

# Functions that only kernels call: compiled into their callers, and so neither wrapped for Python
# nor cached (and loaded, at every start) on their own. They carry no signature; a call from Python
# would crash the process (those that Python needs too are `register_jitable`).
INNER = {**CACHE, "cache": False, "no_cpython_wrapper": True}

# The hot path: passing a function a dozen arrays costs more than most of them do.
INLINE = {**INNER, "forceinline": True}


def kernel_key() -> str:
    """Hash of the kernels and of numba itself."""
    folder = Path(__file__).parent
    files = [folder / name for name in KERNEL_FILES]
    return content_key([source_of(*files), numba.__version__])


def is_warm() -> bool:
    """Whether this user's cache holds the compiled kernels."""
    folder = Path(numba.config.CACHE_DIR)
    return any(folder.rglob("kernel.advance*.nbc"))


numba.config.CACHE_DIR = str(cache_root() / f"kernels-{kernel_key()}")
# Loops run over a dozen terms: vectors gain nothing, and take an eighth of the time to compile.
numba.config.LOOP_VECTORIZE = 0
