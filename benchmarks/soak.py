"""One process that orders, plans and rebuilds worlds for hours, and the same work side by side."""

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from topple.benchmarks.row import Progress
from topple.benchmarks.sabotages.caught import BASE, GOALS, scene_for
from topple.planner.execution.rehearsal import Rehearsal
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan
from topple.robots.catalog import robot
from topple.robots.engine import pybullet
from topple.topology.base.workers import WorkerPool
from topple.topology.scene.scene import Scene

PLANS = 10  # orders and worlds for each plan, which takes as long as ten of them
CLIENTS = 64  # numbers of simulations that are looked at
THREADS, PROCESSES = 3, 4


@dataclass(frozen=True)
class Held:
    """What a process still holds after many rounds.

    Attributes:
        rounds: How many.
        growth: Memory after a round, median of the last third against that of the second.
        megabytes: That of the last third.
        clients: Simulations that are still open.
        threads: More than there were at the start.
        files: Open files, more than after the first round.
    """

    rounds: int
    growth: float
    megabytes: float
    clients: int
    threads: int
    files: int


def soak(rounds: int) -> Held:
    """Order, rebuild a world and now and then plan, again and again, in this process.

    Args:
        rounds: How often, at least 3.

    Returns:
        What is left of it.
    """
    arm, threads, files, memory = robot("panda"), threading.active_count(), 0, list[int]()
    for number in range(rounds):
        goal = GOALS[number % len(GOALS)]
        scene = _anew(scene_for(goal))
        order(scene, [scene.movable[0]])
        with Rehearsal.of(scene, arm, BASE):
            pass
        if number % PLANS == 0:
            plan(scene, goal, arm, pose_base_to_world=BASE)
        memory.append(_memory())
        files = files if number else _files()
    third = max(1, rounds // 3)
    return Held(
        rounds,
        median(memory[-third:]) / median(memory[-2 * third : -third]),
        median(memory[-third:]) / 1e6,
        sum(_is_open(client) for client in range(CLIENTS)),
        threading.active_count() - threads,
        _files() - files,
    )


def soaked(rounds: int, progress: Progress) -> Held:
    """`soak` in a fresh process, which nothing else has filled.

    Args:
        rounds: How often.
        progress: Called once.
    """
    progress(f"{rounds} rounds of orders, plans and worlds in one process")
    with WorkerPool(1) as pool:
        return pool.submit(soak, rounds).result()


def side_by_side(copies: int, progress: Progress) -> tuple[int, int]:
    """Ask threads and processes for what is also asked one after the other.

    Args:
        copies: How often each scene is ordered.
        progress: Called once.

    Returns:
        How many answers came, and how many of them are not those that come one after the other.
    """
    progress("the same orders in three threads and in four processes")
    goals = GOALS * copies
    serial = [_ordered(goal) for goal in goals]
    with ThreadPoolExecutor(THREADS) as threads:
        in_threads = list(threads.map(_ordered, goals))
    with WorkerPool(PROCESSES) as processes:
        in_processes = list(processes.map(_ordered, goals))
    differ: Callable[[list[dict[str, Any]]], int] = partial(_differences, serial)
    return 2 * len(serial), differ(in_threads) + differ(in_processes)


def _differences(a: list[dict[str, Any]], b: list[dict[str, Any]]) -> int:
    return sum(one != other for one, other in zip(a, b, strict=True))


def _ordered(goal: str) -> dict[str, Any]:
    scene = _anew(scene_for(goal))
    return order(scene, [scene.movable[0]]).to_json()


def _anew(scene: Scene) -> Scene:
    """The same scene, of which nothing was worked out yet."""
    return Scene(dict(scene.clouds), fixed=sorted(scene.fixed), up=scene.up)


def _is_open(client: int) -> bool:
    return bool(pybullet.getConnectionInfo(client)["isConnected"])


def _files() -> int:
    return len(os.listdir("/proc/self/fd"))


def _memory() -> int:
    """Memory this process holds [bytes]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
