"""Processes that work for this one, and tasks mapped on them; they do not outlive it."""

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from itertools import islice
from multiprocessing import connection, get_context, parent_process
from typing import Generic, TypeVar

Task = TypeVar("Task")
Answer = TypeVar("Answer")

AHEAD = 8
"""Tasks under way, or answered before their turn, for each worker: memory does not grow with the tasks."""


def serve() -> None:
    """Ready a process that works for another: every worker of topple begins with this.

    Ctrl-C reaches every process of a terminal; what to do then is for the one that was started by somebody.
    A process that is killed ends none of its children: they see that it is gone, and leave at once.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def worker_pool(processes: int) -> ProcessPoolExecutor:
    """A pool of fresh processes that serve.

    Args:
        processes: How many at most.

    Returns:
        The pool.
    """
    return ProcessPoolExecutor(processes, get_context("spawn"), initializer=serve)


def _leave_with_parent() -> None:
    """Wait for the end of the process that started this one; nothing of what is done here counts then."""
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


class Lost(Generic[Task]):
    """In place of an answer: the worker of this task was lost, twice.

    Attributes:
        task: What it worked on.
    """

    def __init__(self, task: Task) -> None:
        self.task = task


def mapped(
    work: Callable[[Task], Answer],
    tasks: Iterable[Task],
    executor: Callable[[], Executor],
    workers: int,
) -> Iterator[Answer | Lost[Task]]:
    """Answer tasks on the workers of an executor, in order; a lost worker costs no other task.

    A pool of processes is broken as a whole where one of its processes is killed. It is made anew, what was
    under way is begun again, and the first of it alone: a task that kills its worker every time is given up.

    Args:
        work: Answers one; it, the tasks and the answers go to other processes.
        tasks: Any number of them; asked for as they are needed.
        executor: Makes the executor, and another one where that is broken.
        workers: How many tasks it works on at a time.

    Yields:
        The answers, in the order of the tasks; whatever else `work` raises comes through.
    """
    left, waiting = iter(tasks), deque[tuple[Task, Future[Answer]]]()
    pool = executor()
    try:
        while True:
            for task in islice(left, AHEAD * workers - len(waiting)):
                waiting.append((task, _submitted(pool, work, task)))
            if not waiting:
                return
            task, future = waiting[0]
            try:
                answer: Answer | Lost[Task] = future.result()
            except BrokenExecutor:
                pool.shutdown(wait=False)
                pool = executor()
                try:
                    answer = pool.submit(work, task).result()
                except BrokenExecutor:
                    answer, pool = Lost(task), executor()
                again = [one for one, _ in waiting][1:]
                waiting = deque([(task, future), *((one, _submitted(pool, work, one)) for one in again)])
            waiting.popleft()
            yield answer
    finally:
        for _, future in waiting:
            future.cancel()
        pool.shutdown(wait=False)


def _submitted(pool: Executor, work: Callable[[Task], Answer], task: Task) -> Future[Answer]:
    """A task handed to a pool; a future that is broken already where the pool is."""
    try:
        return pool.submit(work, task)
    except BrokenExecutor as error:
        broken: Future[Answer] = Future()
        broken.set_exception(error)
        return broken
