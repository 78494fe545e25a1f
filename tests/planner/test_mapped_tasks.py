"""Many tasks on the workers of an executor."""

import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest

from topple.planner.workers import AHEAD, Lost, mapped, worker_pool


def squared(number: int) -> int:
    return number * number


def killed_at(place: Path, always: bool, number: int) -> int:
    """The square, but for 3: its process is killed the first time, or every time."""
    if number == 3 and (always or not place.exists()):
        place.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def test_answers_come_in_order_and_tasks_are_asked_for_as_they_are_needed() -> None:
    asked: list[int] = []

    def tasks() -> Iterator[int]:
        for number in range(100):
            asked.append(number)
            yield number

    answers = mapped(squared, tasks(), partial(ThreadPoolExecutor, 2), 2)
    assert next(answers) == 0
    assert len(asked) <= 2 * AHEAD
    assert list(answers) == [number * number for number in range(1, 100)]


def test_what_work_raises_comes_through() -> None:
    with pytest.raises(ZeroDivisionError):
        list(mapped(lambda number: 1 // number, [1, 0], partial(ThreadPoolExecutor, 1), 1))


@pytest.mark.slow
@pytest.mark.parametrize("always", [False, True])
def test_a_killed_worker_costs_its_task_at_most(tmp_path: Path, always: bool) -> None:
    work = partial(killed_at, tmp_path / "killed", always)
    found = list(mapped(work, range(8), partial(worker_pool, 2), 2))
    lost = [answer for answer in found if isinstance(answer, Lost)]
    assert [answer.task for answer in lost] == ([3] if always else [])
    kept = [answer for answer in found if not isinstance(answer, Lost)]
    assert kept == [number * number for number in range(8) if not (always and number == 3)]


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # those of the cluster's start and end are not topple's
def test_a_dask_cluster_answers_alike() -> None:
    distributed = pytest.importorskip(
        "distributed", reason="dask is not installed: pip install 'topple-planner[dask]'"
    )
    with distributed.Client(processes=False, dashboard_address=None) as client:
        assert list(mapped(squared, range(30), client.get_executor, 2)) == [n * n for n in range(30)]
