"""Processes that work for this one: they leave Ctrl-C to it, and do not outlive it."""

import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import connection, get_context, parent_process


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
