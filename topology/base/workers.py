"""Processes that work for this one, and tasks spread over the workers of any executor."""

import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from itertools import islice
from multiprocessing import connection, get_context, parent_process, resource_tracker
from types import TracebackType
from typing import Any, Generic, TypeVar

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import InvalidInput, ToppleError

Task = TypeVar("Task")
Answer = TypeVar("Answer")

AHEAD = 8
"""Tasks under way, or answered before their turn, for each worker: memory does not grow with the tasks."""


class WorkerLost(ToppleError):
    """Whoever worked on a task was lost every time: killed, or for want of memory.

    Examples:
        >>> issubclass(WorkerLost, ToppleError)
        True
    """


class Lost(Generic[Task]):
    """In place of an answer: the worker of this task was lost every time.

    Attributes:
        task: What it worked on.
    """

    def __init__(self, task: Task) -> None:
        self.task = task


def serve() -> None:
    """Ready a process that works for another: every worker of topple begins with this.

    Ctrl-C reaches every process of a terminal; what to do then is for the one that was started by somebody.
    A process that is killed ends none of its children: they see that it is gone, and leave at once.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    """Wait for the end of the process that started this one; nothing of what is done here counts then."""
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


@checked_arguments
class WorkerPool(Executor):
    """Fresh processes that serve, as an executor; one that is killed costs its own task alone.

    A standard pool is broken as a whole where one of its processes is killed: here each is a pool of its own,
    and the next task finds a new one. Left by an exception, what still runs is ended.

    Examples:
        >>> with WorkerPool(1) as pool:
        ...     pool.submit(len, "three").result()
        5
    """

    def __init__(self, processes: int, ready: Callable[[], None] = serve) -> None:
        """Nothing is started before the first task.

        Args:
            processes: How many at most.
            ready: What each begins with.

        Raises:
            InvalidInput: There is none.
        """
        if processes < 1:
            raise InvalidInput(f"processes is {processes}: expected how many there are, 1 or more")
        self._ready = ready
        self._max_workers = processes
        self._threads = ThreadPoolExecutor(processes, initializer=_ignore_interrupt)
        self._of_thread = threading.local()
        self._pids: dict[int, ProcessPoolExecutor] = {}
        self._killed = False

    def submit(self, fn: Callable[..., Answer], /, *args: Any, **kwargs: Any) -> Future[Answer]:
        """Have a call made by the next process that is free; both have to pickle."""
        return self._threads.submit(self._ask_process, fn, args, kwargs)

    def _ask_process(self, fn: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        """Call a function in the process of this thread, which is started for the first call."""
        pid: int | None = getattr(self._of_thread, "pid", None)
        if pid is None:
            pool = ProcessPoolExecutor(1, get_context("spawn"), initializer=self._ready)
            pid = self._of_thread.pid = pool.submit(os.getpid).result()
            self._pids[pid] = pool
            if self._killed:
                _kill(pid)
        try:
            return self._pids[pid].submit(fn, *args, **kwargs).result()
        except BrokenExecutor:
            del self._of_thread.pid
            self._pids.pop(pid).shutdown()  # nothing of it is left once it is known to be lost
            raise

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Take no more tasks, and end the processes once they are idle."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        for pool in list(self._pids.values()):
            pool.shutdown(wait)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the processes: at once where an exception leaves, else once all is done."""
        if kind is None:
            self.shutdown()
        else:
            self.kill()

    def kill(self) -> None:
        """End the processes at once, whatever they are at."""
        self._killed = True
        self._threads.shutdown(wait=False, cancel_futures=True)
        for pid in list(self._pids):
            _kill(pid)
        self.shutdown()


def _ignore_interrupt() -> None:
    """Let what this thread starts not hear of Ctrl-C: a process that is still starting would say a lot."""
    if hasattr(signal, "pthread_sigmask"):
        resource_tracker.ensure_running()  # which lets the thread that starts it hear again
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def map_tasks(
    work: Callable[[Task], Answer],
    tasks: Iterable[Task],
    executor: Executor,
    *,
    in_turn: bool = True,
    tries: int = 2,
) -> Iterator[Answer | Lost[Task]]:
    """Answer tasks on the workers of an executor; a lost worker costs no other task.

    Where the executor is broken as a whole, as a standard pool of processes is once one of them is killed,
    what is left is done by a `WorkerPool`.

    Args:
        work: Answers one; it, the tasks and the answers go to other processes.
        tasks: Any number of them; asked for as they are needed.
        executor: Any of `concurrent.futures`, or that of a dask client (`Client.get_executor()`); it stays
            open.
        in_turn: Whether the answers come in the order of the tasks; else as they are found, and no task is
            asked for before a worker is free.
        tries: How often a `WorkerPool` begins a task whose worker is lost.

    Yields:
        The answers; whatever else `work` raises comes through.
    """
    left = enumerate(tasks)
    workers = _width(executor)
    most = workers * (AHEAD if in_turn else 1)
    waiting: dict[Future[Answer], tuple[int, Task, int]] = {}
    found: dict[int, Answer | Lost[Task]] = {}
    turn = 0
    with ExitStack() as stack:
        stack.callback(lambda: [future.cancel() for future in waiting])

        def begin(number: int, task: Task, tried: int) -> None:
            nonlocal executor
            try:
                future = executor.submit(work, task)
            except BrokenExecutor:
                executor = stack.enter_context(WorkerPool(workers))
                future = executor.submit(work, task)
            waiting[future] = (number, task, tried + isinstance(executor, WorkerPool))

        while True:
            for number, task in islice(left, most - len(waiting) - len(found)):
                begin(number, task, 0)
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                number, task, tried = waiting.pop(future)
                try:
                    found[number] = future.result()
                except BrokenExecutor:
                    if tried < tries:
                        begin(number, task, tried)
                    else:
                        found[number] = Lost(task)
                except Exception as error:
                    if type(error).__name__ != "KilledWorker":  # dask's, which has tried others by then
                        raise
                    found[number] = Lost(task)
            while found and (turn in found or not in_turn):
                yield found.pop(turn if in_turn else next(iter(found)))
                turn += 1


def all_of(
    work: Callable[[Task], Answer], tasks: Iterable[Task], executor: Executor | None
) -> Iterator[Answer]:
    """Answer tasks in their order, on the workers of an executor where one is given.

    Args:
        work: Answers one; with an executor it, the tasks and the answers go to other processes.
        tasks: Any number of them.
        executor: See `map_tasks`; None answers here, one after the other.

    Raises:
        WorkerLost: A task lost its worker twice.
    """
    if executor is None:
        yield from map(work, tasks)
        return
    for number, answer in enumerate(map_tasks(work, tasks, executor), 1):
        if isinstance(answer, Lost):
            raise WorkerLost(f"scene {number}: the process that worked on it was lost twice")
        yield answer


def open_executor(executor: Executor | None) -> AbstractContextManager[Executor]:
    """An executor for a while: the one that is given, which stays open, or one process a core.

    Args:
        executor: What is given, if anything.
    """
    return WorkerPool(os.cpu_count() or 1) if executor is None else nullcontext(executor)


def _width(executor: Executor) -> int:
    """How many tasks an executor works on at a time, as far as it tells."""
    client: Any = getattr(executor, "_client", None)  # dask's
    if client is not None:
        return max(1, sum(client.nthreads().values()))
    return getattr(executor, "_max_workers", None) or os.cpu_count() or 1
