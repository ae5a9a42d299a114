"""Worker threads for user code, the queue before them, and the time-outs of its requests.

A thread that owns a service holds the lock of its host, as a worker does but while it calls
user code. One worker runs at a time, so that objects of users are seldom called by two threads;
where it is not back soon, another one takes over the queue.

See decision 38.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any

from rtkit.guard import GuardedResult, guarded
from rtkit.property.codes import PropertyError
from rtkit.property.lanes import ALONE
from rtkit.property.messages import Answer
from rtkit.property.user_code import Cancel, Finished, UserCode, Work, is_coroutine
from rtkit.serving.coroutines import Coroutines

HAND_OVER_S = 0.05
"""How long user code may hold up other user code [s]."""
LONGEST_S = 60.0
"""How long a request waits for user code unless it says how long [s]."""
MOST_THREADS = 64
MOST_WAITING = 4096
_MOST_ACTIONS = 64
_LEAST_WAIT_S = 1.0
"""Time-out of a request that may end later by what the loop takes to look again [s]."""
_CLOSING_S = 1.0
LATE = Answer("the code behind it has not answered in time", "timeout")


class _Job:
    """Call of user code, and the requester to refuse when it takes too long.

    Attributes:
        when_slow: Called on the loop once it holds up others; None where nobody has to know.
    """

    __slots__ = ("began_at", "is_slow", "lane", "refuse", "until", "when_slow", "work")

    def __init__(
        self, lane: str, work: Work, refuse: Callable[[Answer], object], until: float
    ) -> None:
        self.lane = lane
        self.work = work
        self.refuse: Callable[[Answer], object] | None = refuse
        self.until = until
        self.began_at = 0.0
        self.is_slow = False
        self.when_slow: Work | None = None


class Workers(UserCode):
    """Runs the user code of one host; all but `call`, `post` and `awaited` by its owner.

    Args:
        lock: Of the host.
        post: Has the loop of the host do something; from any thread.
    """

    def __init__(self, lock: threading.Lock, post: Callable[[Work], None]) -> None:
        self._post = post
        self._lock = lock
        self._wakeup = threading.Condition(lock)
        self._lanes: dict[str, deque[_Job]] = {}
        self._due: deque[_Job] = deque()
        self._jobs: dict[_Job, None] = {}
        self._threads: dict[int, threading.Thread] = {}
        self._here: dict[int, Work] = {}
        self._idle = 0
        self._slow = 0
        self._actions = 0
        self._late: dict[object, tuple[float, Callable[[Answer], object]]] = {}
        self._is_closed = False
        self._coroutines = Coroutines()

    # Methods for services

    def call(self, work: Work) -> GuardedResult:
        """See `UserCode.call`; a worker lets go of the lock meanwhile."""
        if threading.get_ident() not in self._threads:
            return self._called(work)
        self._lock.release()
        try:
            return self._called(work)
        finally:
            self._lock.acquire()

    def post(self, work: Work) -> None:
        """See `UserCode.post`."""
        self._post(work)

    def _called(self, work: Work) -> GuardedResult:
        outcome = guarded(work)
        if is_coroutine(outcome.result):
            return guarded(lambda: self.awaited(outcome.result, lambda cancel: None))
        return outcome

    def later(self, lane: str, work: Work, refuse: Callable[[Answer], object], wait: float) -> None:
        """See `UserCode.later`."""
        if len(self._jobs) >= MOST_WAITING:
            refuse(Answer(f"{MOST_WAITING} requests wait for slow ones", "busy"))
            return
        job = _Job(lane, work, refuse, monotonic() + (wait or LONGEST_S))
        self._jobs[job] = None
        queue = self._lanes.setdefault(lane, deque())
        queue.append(job)
        if len(queue) > 1:
            return
        job.when_slow = self._here.get(threading.get_ident())
        if job.when_slow is not None and self._may_begin_here(job, wait):
            self._carry_out_here(job)
        else:
            job.when_slow = None
            self._due.append(job)
            self._engage()

    @contextmanager
    def called_here(self, when_slow: Work) -> Iterator[None]:
        """Have this thread, which serves one client, call the code that its client asks for.

        So nothing is handed over. It is the one worker meanwhile.

        Args:
            when_slow: Called on the loop when it holds up others, before it has come back.
        """
        ident = threading.get_ident()
        self._here[ident] = when_slow
        try:
            yield
        finally:
            del self._here[ident]

    def _may_begin_here(self, job: _Job, wait: float) -> bool:
        """Return whether no other user code runs or is due, and no exact time-out matters."""
        is_exact = 0 < wait < _LEAST_WAIT_S
        if is_exact or self._due or job.lane.startswith(ALONE):
            return False
        return not any(each.began_at and not each.is_slow for each in self._jobs)

    def _carry_out_here(self, job: _Job) -> None:
        ident = threading.get_ident()
        self._threads[ident] = threading.current_thread()
        try:
            self._carry_out(job)
        finally:
            del self._threads[ident]
        if self._due:
            self._engage()

    def start(self, work: Work, finished: Finished) -> None:
        """See `UserCode.start`: on a thread of its own."""
        if self._actions >= _MOST_ACTIONS:
            raise PropertyError("busy", f"{_MOST_ACTIONS} calls are running")
        self._actions += 1

        def end(outcome: GuardedResult) -> None:
            self._actions -= 1
            finished(outcome.result, outcome.error)

        def run() -> None:
            outcome = self._called(work)
            self.post(lambda: end(outcome))

        threading.Thread(target=run, name="call", daemon=True).start()

    def refuse_after(self, wait: float, refuse: Callable[[Answer], object]) -> Callable[[], object]:
        """See `UserCode.refuse_after`."""
        key = object()
        self._late[key] = (monotonic() + wait, refuse)
        return lambda: self._late.pop(key, None)

    def awaited(
        self, coroutine: Coroutine[Any, Any, object], cancellable: Callable[[Cancel], object]
    ) -> object:
        """See `UserCode.awaited`."""
        return self._coroutines.run(coroutine, cancellable)

    # Methods for the loop

    def check(self, now: float) -> float | None:
        """Refuse what takes too long, have others go on; return when to look again."""
        for key, (until, refuse) in list(self._late.items()):
            if until <= now:
                del self._late[key]
                refuse(LATE)
        times = [until for until, _ in self._late.values()]
        if not self._jobs:
            return min(times, default=None)
        for job in [each for each in self._jobs if each.until <= now]:
            self._give_up(job)
        running = [job for job in self._jobs if job.began_at and not job.is_slow]
        for job in running:
            if job.began_at + HAND_OVER_S <= now:
                job.is_slow = True
                self._slow += 1
                if job.when_slow is not None:
                    job.when_slow()
        if self._due:
            self._engage()
        times += [job.until for job in self._jobs if job.refuse is not None]
        if self._due:
            ends = [job.began_at + HAND_OVER_S for job in running if not job.is_slow]
            times += ends or [now + HAND_OVER_S]  # a worker that has still to begin
        return min(times, default=None)

    def _give_up(self, job: _Job) -> None:
        """Refuse work that has not ended in time; work that has not begun by now never does."""
        refuse, job.refuse = job.refuse, None
        if refuse is not None:
            refuse(LATE)
        if not job.began_at and self._lanes[job.lane][0] is not job:
            self._lanes[job.lane].remove(job)
            del self._jobs[job]

    def _engage(self) -> None:
        """Engage a worker for work that is due: one that waits, else a new one if all are slow."""
        if any(job.when_slow and job.began_at and not job.is_slow for job in self._jobs):
            self._post(_look)  # it engages one when it is back, the loop when it is slow
        elif self._idle:
            self._wakeup.notify()
        elif len(self._threads) - self._slow < 1 and len(self._threads) < MOST_THREADS:
            thread = threading.Thread(target=self._run, name="user-code", daemon=True)
            thread.start()
            assert thread.ident is not None
            self._threads[thread.ident] = thread

    # Methods of workers

    def _run(self) -> None:
        with self._lock:
            try:
                self._work()
            finally:
                del self._threads[threading.get_ident()]

    def _work(self) -> None:
        while not self._is_closed:
            if not self._due:
                self._idle += 1
                self._wakeup.wait()
                self._idle -= 1
                continue
            job = self._due.popleft()
            self._carry_out(job)
            if job.is_slow and len(self._threads) - self._slow > 1:
                self._wakeup.notify()  # another one has taken over
                break

    def _carry_out(self, job: _Job) -> None:
        job.began_at = monotonic()
        if job.lane.startswith(ALONE):
            job.is_slow = True  # it is known to take its time
            self._slow += 1
            if self._due:
                self._engage()
        if job.refuse is not None:
            job.work()
        del self._jobs[job]
        self._slow -= job.is_slow
        queue = self._lanes[job.lane]
        queue.popleft()
        if queue:
            self._due.append(queue[0])
        else:
            del self._lanes[job.lane]

    def close(self) -> None:
        """Begin nothing any more; user code that does not end is left behind."""
        with self._lock:
            self._is_closed = True
            self._wakeup.notify_all()
            busy = {job for job in self._jobs if job.began_at}
            waits = [] if busy else list(self._threads.values())
        for thread in waits:
            if thread is not threading.current_thread():
                thread.join(_CLOSING_S)
        self._coroutines.close()


def _look() -> None:
    """Do nothing: the loop looks at the workers after whatever it was asked to do."""
