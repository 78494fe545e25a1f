"""CPU times: they hold on a busy machine, and ratios of them on other machines too."""

import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any


def cpu_seconds(call: Callable[[], Any]) -> float:
    """CPU time of one call [s], all threads of this process together."""
    begun = time.process_time()
    call()
    return time.process_time() - begun


def cpu_medians(calls: Sequence[Callable[[], Any]], repeats: int) -> list[float]:
    """Median CPU times of several calls [s].

    The calls take turns, so that what else the machine does meets all of them alike.

    Args:
        calls: What to measure.
        repeats: How often each is called.

    Returns:
        One median per call.
    """
    times: list[list[float]] = [[] for _ in calls]
    for _ in range(repeats):
        for call, taken in zip(calls, times, strict=True):
            taken.append(cpu_seconds(call))
    return [median(taken) for taken in times]
