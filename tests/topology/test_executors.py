"""Many scenes on the workers of an executor give what one after the other gives."""

from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from topple.topology import Scene, relate, relate_all


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


def check(executor: Executor) -> None:
    for plain in (False, True):
        together = relate_all(scenes(), plain=plain, executor=executor)
        alone = [relate(scene, plain=plain) for scene in scenes()]
        assert [each.to_json() for each in together] == [each.to_json() for each in alone]
        cloud = scenes()[0].clouds["one"] + [0.0, 0.1, 0.0]
        assert together[0].updated("one", cloud).to_json() == alone[0].updated("one", cloud).to_json()


@pytest.mark.parametrize("pool", ["threads", pytest.param("processes", marks=pytest.mark.slow)])
def test_a_pool_of_two_relates_like_one_after_the_other(pool: str) -> None:
    if pool == "threads":
        with ThreadPoolExecutor(2) as threads:
            check(threads)
    else:
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
            check(processes)


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # those of the cluster's start and end are not topple's
def test_a_dask_cluster_of_two_workers_relates_like_one_after_the_other() -> None:
    distributed = pytest.importorskip(
        "distributed", reason="dask is not installed: pip install 'topple-planner[dask]'"
    )
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert len(client.scheduler_info()["workers"]) == 2
        check(client.get_executor())
