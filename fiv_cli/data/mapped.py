"""Arrays that lie in a file without a name, so that memory holds only what is at work.

For datasets that are larger than a process should be: the system writes to the disk what it needs
the room for, and `let_go` tells it what is not needed for now.
"""

from __future__ import annotations

import mmap
import tempfile
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def mapped(value: Any, shape: tuple[int, ...], dtype: np.dtype[Any], folder: Path) -> Array:
    """An array of a value, or of values, in a file in `folder` that goes with it."""
    count = prod(shape)
    with tempfile.TemporaryFile(dir=folder) as file:
        file.truncate(max(1, count * dtype.itemsize))
        memory = mmap.mmap(file.fileno(), 0)
    array = np.frombuffer(memory, dtype, count).reshape(shape)
    array[...] = value
    let_go(array)
    return array


def let_go(array: Any) -> None:
    """What an array holds is not needed for now; nothing is done to one that lies in no file."""
    while isinstance(array, np.ndarray):
        array = array.base
    if isinstance(array, memoryview) and isinstance(array.obj, mmap.mmap):
        array.obj.madvise(mmap.MADV_DONTNEED)
