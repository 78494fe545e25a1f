"""Many tasks on the workers of any executor: the same answers, in order, and a lost worker costs its task."""

import os
import signal
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pytest

from topple.topology.base.errors import InvalidInput
from topple.topology.base.workers import AHEAD, Lost, WorkerLost, WorkerPool, all_of, map_tasks

SQUARES = [number * number for number in range(8)]


def squared(number: int) -> int:
    return number * number


def killed_at(place: Path, always: bool, number: int) -> int:
    """The square, but for 3: its process is killed the first time, or every time."""
    if number == 3 and (always or not place.exists()):
        place.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


class Undone(Executor):
    """Never does anything, and knows what it was asked."""

    _max_workers = 2

    def __init__(self) -> None:
        self.asked = 0

    def submit(self, *_: object, **__: object) -> Future[int]:  # type: ignore[override]
        self.asked += 1
        future: Future[int] = Future()
        if self.asked == 2:  # the second is answered before the first
            future.set_result(1)
        return future


def test_answers_come_in_order_and_tasks_are_asked_for_as_they_are_needed():
    asked: list[int] = []

    def tasks() -> Iterator[int]:
        for number in range(100):
            asked.append(number)
            yield number

    with ThreadPoolExecutor(2) as executor:
        answers = map_tasks(squared, tasks(), executor)
        assert next(answers) == 0
        assert len(asked) <= 2 * AHEAD
        assert list(answers) == [number * number for number in range(1, 100)]


def test_out_of_turn_what_is_found_comes_first_and_no_task_waits_for_a_worker():
    executor = Undone()
    answers = map_tasks(squared, range(100), executor, in_turn=False)
    assert next(answers) == 1
    assert executor.asked == 2


def test_what_work_raises_comes_through():
    with pytest.raises(ZeroDivisionError), ThreadPoolExecutor(1) as executor:
        list(map_tasks(lambda number: 1 // number, [1, 0], executor))


@pytest.mark.slow
@pytest.mark.parametrize("always", [False, True])
@pytest.mark.parametrize("standard", [False, True], ids=["ours", "standard"])
def test_a_killed_worker_costs_its_task_at_most(tmp_path, always, standard):
    work = partial(killed_at, tmp_path / "killed", always)
    with ProcessPoolExecutor(2, get_context("spawn")) if standard else WorkerPool(2) as executor:
        found = list(map_tasks(work, range(8), executor))
    lost = [answer for answer in found if isinstance(answer, Lost)]
    assert [answer.task for answer in lost] == ([3] if always else [])
    kept = [answer for answer in found if not isinstance(answer, Lost)]
    assert kept == [square for number, square in enumerate(SQUARES) if not (always and number == 3)]


@pytest.mark.slow
def test_a_task_that_is_tried_once_is_lost_alone(tmp_path):
    work = partial(killed_at, tmp_path / "killed", False)
    with WorkerPool(2) as executor:
        found = list(map_tasks(work, range(8), executor, in_turn=False, tries=1))
    assert [answer.task for answer in found if isinstance(answer, Lost)] == [3]
    assert len(found) == 8


@pytest.mark.slow
def test_what_lost_its_worker_twice_is_named(tmp_path):
    with WorkerPool(1) as executor, pytest.raises(WorkerLost, match="scene 4"):
        list(all_of(partial(killed_at, tmp_path / "killed", True), range(8), executor))


@pytest.mark.slow
def test_a_pool_that_is_left_by_an_exception_does_not_wait_for_its_tasks():
    begun = time.monotonic()
    with pytest.raises(InvalidInput), WorkerPool(1) as executor:
        assert executor.submit(squared, 3).result() == 9
        executor.submit(time.sleep, 60)
        raise InvalidInput("enough")
    assert time.monotonic() - begun < 20


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # those of the cluster's start and end are not topple's
def test_a_dask_cluster_answers_alike_though_a_worker_is_killed(cluster, tmp_path):
    work = partial(killed_at, tmp_path / "killed", False)
    assert list(map_tasks(work, range(8), cluster)) == SQUARES
    assert (tmp_path / "killed").exists()
