"""Many scenes on the workers of an executor give what one after the other gives."""

import pickle
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from topple.planner import order, order_all
from topple.topology import Scene, WorkerPool, load_scene, relate, relate_all


def scenes(count: int = 3) -> list[Scene]:
    """Two balls on a table each, nearer and nearer."""
    found: list[Scene] = []
    for number in range(count):
        rng = np.random.default_rng(number)
        ball = rng.normal(size=(800, 3))
        ball *= 0.04 / np.linalg.norm(ball, axis=1, keepdims=True)
        table = np.c_[rng.uniform(-0.3, 0.3, (2000, 2)), np.zeros(2000)]
        apart = np.array([0.1 - 0.01 * number, 0.0, 0.0])
        up = np.array([0.0, 0.0, 0.04])
        found.append(
            Scene({"table": table, "one": ball + up, "other": ball + up + apart}, ["table"], [0, 0, 1])
        )
    return found


BOUND = 10_000
"""Bytes that may come back of one scene: half of what one of its clouds has."""


class Weighed(ThreadPoolExecutor):
    """Threads, whose answers are weighed as processes would send them."""

    def submit(self, fn, /, *args):  # type: ignore[no-untyped-def, override]
        return super().submit(_sent, fn, *args)


def _sent(fn, *args):  # type: ignore[no-untyped-def]
    sent = pickle.dumps(fn(*args))
    assert len(sent) < BOUND
    return pickle.loads(sent)


def check(executor: Executor, folder: Path) -> None:
    paths = [folder / f"{number}.npz" for number in range(3)]
    for path, scene in zip(paths, scenes(), strict=True):
        np.savez(path, **scene.clouds, fixed=["table"], up=[0, 0, 1], viewpoints=[[0.0, -0.5, 0.5]])
    seen = [load_scene(path) for path in paths]
    for rule in ("robust", "plain"):
        alone = [relate(scene, rule=rule) for scene in seen]
        for given in (seen, paths):
            together = relate_all(given, rule=rule, executor=executor)
            assert together == alone
            assert [each.to_json() for each in together] == [each.to_json() for each in alone]
        cloud = seen[0].clouds["one"] + [0.0, 0.1, 0.0]
        assert together[0].updated("one", cloud).to_json() == alone[0].updated("one", cloud).to_json()
    assert order_all(paths, executor=executor) == [order(scene) for scene in seen]


@pytest.mark.parametrize(
    "pool",
    [
        partial(ThreadPoolExecutor, 2),
        partial(Weighed, 2),
        pytest.param(partial(WorkerPool, 2), marks=pytest.mark.slow),
        pytest.param(partial(ProcessPoolExecutor, 2, get_context("spawn")), marks=pytest.mark.slow),
    ],
    ids=["threads", "weighed", "ours", "processes"],
)
def test_a_pool_of_two_answers_like_one_after_the_other(pool, tmp_path):
    with pool() as executor:
        check(executor, tmp_path)


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # those of the cluster's start and end are not topple's
def test_a_dask_cluster_of_two_workers_answers_like_one_after_the_other(cluster, tmp_path):
    check(cluster, tmp_path)
