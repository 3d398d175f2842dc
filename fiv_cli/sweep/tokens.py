"""What worker processes share: locks that leave nothing behind.

loky's own ones are named semaphores, which stay in /dev/shm when the whole process group is
killed. A pipe with a byte for each token does the same and goes with the last process.
"""

from __future__ import annotations

import os
import select
import time
from multiprocessing.context import get_spawning_popen
from typing import Any

from joblib.externals.loky.backend.context import LokyContext


class Tokens:
    """A semaphore: as many may hold it at once as there are tokens.

    Parameters
    ----------
    count : of tokens, few enough to fit into a pipe
    """

    def __init__(self, count: int = 1) -> None:
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        os.write(self._writer, bytes(count))

    def acquire(self, block: bool = True, timeout: float | None = None) -> bool:
        """Take a token; False where there is none (in time)."""
        end = None if timeout is None else time.monotonic() + timeout
        while not self._taken():
            left = 0.0 if not block else None if end is None else max(0.0, end - time.monotonic())
            if not self._wait(left):
                return False
        return True

    def release(self) -> None:
        """Give a token back."""
        os.write(self._writer, b"\0")

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *exception: object) -> None:
        self.release()

    def _taken(self) -> bool:
        try:
            return bool(os.read(self._reader, 1))
        except BlockingIOError:
            return False

    def _wait(self, seconds: float | None) -> bool:
        """Whether there is a token within so many seconds; another may be quicker."""
        poll = select.poll()
        poll.register(self._reader, select.POLLIN)
        return bool(poll.poll(None if seconds is None else 1000.0 * seconds))

    # --- what queues look into ---
    @property
    def _semlock(self) -> Tokens:
        return self

    def _is_zero(self) -> bool:
        return not self._wait(0.0)

    # --- handed to a process that is being started ---
    def __getstate__(self) -> tuple[int, int]:
        process: Any = get_spawning_popen()
        return tuple(map(process.duplicate_for_child, (self._reader, self._writer)))

    def __setstate__(self, ends: tuple[int, int]) -> None:
        self._reader, self._writer = ends

    def __del__(self) -> None:
        os.close(self._reader)
        os.close(self._writer)


class Context(LokyContext):
    """How loky starts processes, but for the locks; keeps the processes in `started`."""

    Lock = Tokens
    BoundedSemaphore = Tokens

    def __init__(self) -> None:
        super().__init__()
        self.started: list[Any] = []

    def Process(self, *arguments: Any, **named: Any) -> Any:
        """A process to start."""
        process = LokyContext.Process(*arguments, **named)
        self.started.append(process)
        return process
