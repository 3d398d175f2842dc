"""Runs what is left of a plan and stores it, chunk by chunk.

The parent alone writes. Cost settings (workers, chunks, order) never reach a value: a task only
says which points to run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from fiv_cli import ending
from fiv_cli.data.log import came
from fiv_cli.errors import FivError
from fiv_cli.notation.amounts import HOUR, duration
from fiv_cli.sweep.defaults import unequal_defaults
from fiv_cli.sweep.failures import Failures
from fiv_cli.sweep.journal import Journal
from fiv_cli.sweep.plan import counted
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Progress
from fiv_cli.sweep.queue import Job, Queue
from fiv_cli.sweep.stiff import stiff_laws
from fiv_cli.sweep.worker import Result, imported, lost_point, run_task
from fiv_cli.sweep.workers import GLANCE, Beat, Workers

SHARE_OF_PAST = 0.02
"""How long a chunk may take, in the time that was spent before: what a kill can lose of it."""

LONGEST_CHUNK = 20.0
"""Seconds that a chunk may take at most."""

LARGEST_CHUNK = 16 * 2**20
"""Bytes that the results of a chunk may take: memory of that size is used again and again."""

LONG = HOUR
"""Seconds that a run may still take without a word."""

SETTLED = 5
"""Tasks after which what they cost says what the rest will."""

LOADING = 1.0
"""Seconds that a first point may take to load code before it counts as slow itself."""

NOT_SLOW, LINGERING = 0.5, 2.0
"""Seconds that a point may take without being called slow: one that has ended, one that has not."""

FRUITLESS_RESTARTS = 3
"""Deaths of workers in a row, none of which had begun a point, after which we give up."""


@dataclass
class Pace:
    """Measured cost of the points of one analysis.

    Attributes
    ----------
    seconds_per_point, bytes_per_point : of late; None: no task has ended
    spent : seconds, in all tasks
    last_count : points of the task handed out last
    tasks : that have ended
    """

    seconds_per_point: float | None = None
    bytes_per_point: float = 1.0
    spent: float = 0.0
    last_count: int = 0
    tasks: int = 0

    def learn(self, points: int, seconds: float, nbytes: int) -> None:
        """Take a finished task into account; the first, which also loads code, only until then."""
        cost, self.bytes_per_point = seconds / points, nbytes / points
        before = self.seconds_per_point
        self.tasks += 1
        self.spent += seconds
        if before is None or self.tasks == 2:
            self.seconds_per_point = cost
        else:
            self.seconds_per_point = 0.7 * before + 0.3 * cost

    def count(self, left: int, workers: int, policy: Policy) -> int:
        """Points of the next task: short tasks first, then as long as `policy` aims for.

        `workers` share what is left; with 0 of them it all falls to this process.
        """
        if policy.chunk_points is not None:
            return policy.chunk_points
        if self.seconds_per_point is None or self.tasks == 1:
            return 1
        cost = max(self.seconds_per_point, 1e-7)
        target = min(max(policy.chunk_seconds, SHARE_OF_PAST * self.spent), LONGEST_CHUNK)
        share = -(-left // (4 * workers)) if workers else left
        room = LARGEST_CHUNK / self.bytes_per_point
        self.last_count = int(max(1, min(target / cost, room, share, 8 * self.last_count + 8)))
        return self.last_count

    def remaining(self, left: int) -> float | None:
        """Estimated work, s; None while what is measured may be the loading of code."""
        cost = self.seconds_per_point
        if cost is None or (self.tasks == 1 and cost < LOADING):
            return None
        return cost * left


@dataclass
class Scheduler:
    """Runs the points that a journal does not hold yet.

    Attributes
    ----------
    journal : where results are stored
    policy : how to run
    progress : told what happens
    log : writes a line into the log of the run
    ran : how many points were run
    awaits : whether workers were started, and none has brought a point yet
    """

    journal: Journal
    policy: Policy
    progress: Progress
    log: Callable[[str], None]
    ran: int = 0
    awaits: bool = False
    _paces: defaultdict[int, Pace] = field(default_factory=lambda: defaultdict(Pace))
    _workers: Workers | None = None
    _flights: dict[int, Job] = field(default_factory=dict)
    _held: Job | None = None
    _stopped: bool = False
    _is_foreseen: bool = False
    _is_told: bool = False
    _done: int = 0
    _total: int = 0
    _dispatched: int = 0
    _fruitless: int = 0
    _slowest: float = 0.0
    _failures: Failures = field(init=False)

    def __post_init__(self) -> None:
        self._failures = Failures(self.progress.note)

    def __enter__(self) -> Scheduler:
        return self

    def __exit__(self, *exception: object) -> None:
        self._close()
        self.progress.end()

    def run(self) -> bool:
        """Run what the journal wants and does not hold; False when there is nothing more to do.

        Raises
        ------
        StorageError
            a result cannot be stored; what is stored stays.
        """
        plan = self.journal.plan
        queues = [self._queue(index) for index in range(len(plan.analyses))]
        left = sum(queue.left for queue in queues)
        _, self._total = self.journal.progress()
        self._done = max(0, self._total - left)
        self.progress.begin(self._total, self._done)
        if not left:
            return False
        with ending.heeded():
            self._prepare([index for index, queue in enumerate(queues) if queue.left])
            for index, queue in enumerate(queues):
                later = sum(after.left for after in queues[index + 1 :])
                if queue.left:
                    name, record = plan.analyses[index].layout.name, self.journal.records[index]
                    self.progress.turn(name, later, record.grows)
                    self.log(f"{name}: begins, {came(self._done, self._total)}")
                self._drain(index, queue, self._paces[index])
        return not self._full()

    def _queue(self, index: int) -> Queue:
        """What is left of one analysis, as far as is known."""
        analysis, record = self.journal.plan.analyses[index], self.journal.records[index]
        return Queue(analysis, record, self.policy.executor, self.policy.time_limit)

    def _prepare(self, indices: list[int]) -> None:
        """Generate and compile before workers start; on a cluster each host does it.

        This one too, where it is to say how long that takes.
        """
        analyses = [self.journal.plan.analyses[i] for i in indices]
        if self.policy.foresee or not self.policy.cluster:
            requests = (request for analysis in analyses for request in analysis.systems())
            imported(self.policy.preparer)(requests, self.progress.note)
        differing = unequal_defaults(self.journal.plan.case)
        for sentence in [*differing, *stiff_laws(analyses, self.progress.note)]:
            self.progress.note(sentence)
        if self.policy.foresee and not self._is_foreseen:
            self._is_foreseen = True
            self._foresee()

    def _foresee(self) -> None:
        """Say before it begins that a run may take long, from points that are tried."""
        from fiv_cli.sweep.estimate import foreseen

        policy = self.policy
        if policy.cluster:
            self._workers = self._started_workers()
            policy = replace(policy, workers=max(1, self._workers.size))
        found = foreseen(self.journal, policy)
        least, most = (sum(one.slowed * one.seconds[end] for one in found) for end in (0, 1))
        if most > LONG:
            self._is_told = True
            for one in found:
                self.progress.note(f"{one.name} takes {one.time_on_workers()} ({one.basis()})")
            is_open = least < LONG and any(one.given_up for one in found)
            less = ", or far less, as points that were tried were given up" * is_open
            self.progress.note(
                f"this run may take more than an hour{less}: Ctrl-C keeps what is finished, "
                "`fiv check --estimate` tries for longer"
            )

    def _drain(self, index: int, queue: Queue, pace: Pace) -> None:
        """Run everything in one queue, in this process or in workers."""
        self._held = None
        while (queue.left and not self._full()) or self._flights or self._holding():
            ending.heed()
            if self._workers is None and self._wants_workers(pace, queue):
                self._workers = self._started_workers()
            if self._workers is None:
                self._run_here(index, queue, pace)
            else:
                self._run_in_workers(index, queue, pace, self._workers)

    def _full(self) -> bool:
        """Whether nothing more may be started."""
        limit = self.policy.max_points
        return self._stopped or (limit is not None and self._dispatched >= limit)

    def _wants_workers(self, pace: Pace, queue: Queue) -> bool:
        """Workers pay when the work outlasts their start; a wall-clock limit needs them."""
        if self.policy.cluster or self.policy.time_limit is not None:
            return True
        remaining = pace.remaining(queue.left)
        below = self.policy.in_process_below
        if self.policy.workers == 1:
            return False
        return below <= 0.0 or (remaining is not None and remaining > below)

    def _holding(self) -> bool:
        """Whether a job that was taken already waits to be submitted."""
        return self._held is not None and not self._stopped

    def _started_workers(self) -> Workers:
        """Those of a cluster or of this machine; what runs them is imported only then."""
        self.awaits = True
        if self.policy.cluster:
            from fiv_cli.sweep.cluster import Cluster

            return Cluster(self.policy.cluster, self.progress.note)
        from fiv_cli.sweep.pool import WorkerPool

        return WorkerPool(self.policy.workers, self.journal.folder)

    def _next_job(self, queue: Queue, pace: Pace, workers: int) -> Job | None:
        if self._full():
            return None
        count = pace.count(queue.left, workers, self.policy)
        if self.policy.max_points is not None:
            count = min(count, self.policy.max_points - self._dispatched)
        job = queue.next_job(count)
        self._dispatched += 0 if job is None else len(job.positions)
        return job

    def _run_here(self, index: int, queue: Queue, pace: Pace) -> None:
        job = self._next_job(queue, pace, 0)
        if job is not None:
            self._accept(index, queue, pace, job, run_task(job.task))

    def _accept(self, index: int, queue: Queue, pace: Pace, job: Job, result: Result) -> None:
        """Store a result, then let what follows from it run."""
        self.journal.write(index, job.positions, result.block)
        queue.finished(job, result)
        pace.learn(len(job.positions), result.seconds, result.block.nbytes)
        analysis, before = self.journal.plan.analyses[index], self._failures.failed
        self._failures.note(result.block, lambda row: analysis.named(int(job.positions[row])))
        failed = self._failures.failed - before
        self.ran += len(job.positions)
        self._done += len(job.positions)
        self._stopped |= bool(failed) and self.policy.fail_fast
        for row, message in result.block.messages.items():
            self.log(f"point {job.positions[row]}: {message}")
        self._log_chunk(index, job, result, failed)
        self.progress.advance(len(job.positions), failed)
        self._tell_if_long(queue, pace)

    def _log_chunk(self, index: int, job: Job, result: Result, failed: int) -> None:
        """A line of the log; whoever watches hears of a point that took longer than any before."""
        analysis = self.journal.plan.analyses[index]
        row, seconds = result.longest
        where = analysis.named(int(job.positions[row]))
        self.log(
            f"{analysis.layout.name}: {counted(len(job.positions))} in {result.seconds:.2f} s, "
            f"{failed} failed, {came(self._done, self._total)}; slowest {seconds:.2f} s at {where}"
        )
        if seconds > max(self._slowest, NOT_SLOW):
            self._slowest = seconds
            self.progress.slow(seconds, where)

    def _tell_what_goes_on(self, index: int, workers: Workers) -> None:
        """Whoever watches hears of a point that goes on for longer than any before it took."""
        rows = [(b.seconds, self._flights[n].positions[b.row]) for n, b in workers.beats()]
        seconds, position = max(rows, default=(0.0, 0))
        if seconds > max(self._slowest, LINGERING):
            where = self.journal.plan.analyses[index].named(int(position))
            self.progress.slow(seconds, f"{where}, and goes on")

    def _tell_if_long(self, queue: Queue, pace: Pace) -> None:
        """Say once that a run will take long, as soon as its first tasks tell."""
        if self._is_told or pace.tasks < SETTLED or pace.seconds_per_point is None:
            return
        limit = self.policy.max_points
        left = queue.left if limit is None else min(queue.left, limit - self._dispatched)
        workers = self.policy.workers if self._workers is None else max(1, self._workers.size)
        seconds = pace.seconds_per_point * left / workers
        if seconds > LONG:
            self._is_told = True
            self.progress.note(
                f"some {duration(seconds)} to go on {workers} workers, at "
                f"{duration(pace.seconds_per_point)} a point; Ctrl-C keeps what is finished, "
                "`fiv check --estimate` says more"
            )

    def _run_in_workers(self, index: int, queue: Queue, pace: Pace, workers: Workers) -> None:
        """Keep the workers busy, take what is finished, take back what was lost."""
        self._submit_jobs(queue, pace, workers)
        completed = workers.completed(GLANCE)
        ending.heed()  # before workers that were ended with this process count as dead
        for number, result in completed:
            self._fruitless, self.awaits = 0, False
            self._accept(index, queue, pace, self._flights.pop(number), result)
        if not completed:
            self._tell_what_goes_on(index, workers)
        lost = workers.lost()
        if lost:
            self._take_back(index, queue, pace, lost)

    def _submit_jobs(self, queue: Queue, pace: Pace, workers: Workers) -> None:
        """Two jobs per worker; a job that must be alone waits for the others to end."""
        size = max(1, workers.size)
        while len(self._flights) < 2 * size:
            if any(job.alone for job in self._flights.values()):
                return
            if self._held is None:
                self._held = self._next_job(queue, pace, size)
            job = self._held
            if job is None or (job.alone and self._flights):
                return
            self._flights[workers.submit(job.task)] = job
            self._held = None

    def _take_back(
        self, index: int, queue: Queue, pace: Pace, lost: Sequence[tuple[int, Beat | None]]
    ) -> None:
        """After a worker died: run its jobs again, and alone what may have killed it."""
        for number, beat in lost:
            job = self._flights.pop(number)
            if job.alone and beat is not None:
                result = self._given_up(job, beat.seconds)
                self._accept(index, queue, pace, job, result)
            else:
                self._dispatched -= len(job.positions)
                queue.lost(job, None if beat is None else beat.row)
        self.log("a worker died; its points are run again, the suspects alone")
        self._count_fruitless(any(beat is not None for _, beat in lost))

    def _count_fruitless(self, begun: bool) -> None:
        self._fruitless = 0 if begun else self._fruitless + 1
        if self._fruitless > FRUITLESS_RESTARTS:
            raise FivError(
                "worker processes die before they begin to compute\n"
                "next: run again with --workers 1"
            )

    def _given_up(self, job: Job, seconds: float) -> Result:
        """A point that ended its worker a second time, after so many seconds."""
        limit = self.policy.time_limit
        if limit is not None and seconds >= limit:
            return lost_point(job.task, "wall_clock", f"took longer than {limit:g} s")
        return lost_point(job.task, "worker_died", "the worker died twice on this point")

    def _close(self) -> None:
        if self._workers is not None:
            self._workers.close()
            self._workers = None
        self._flights.clear()
