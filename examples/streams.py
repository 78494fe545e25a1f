"""Streams as PDDLStream takes them: facts, grasps, placements and motions, each a generator over a situation.

A block stands on a box. A planner of tasks asks `before` what may be taken, and draws from the others.
"""

from collections.abc import Iterator
from itertools import product

import numpy as np

from topple.planner import dependencies
from topple.planner.grasp.candidates import Grasp, grasp_candidates
from topple.planner.placement.placement import Placement, placements
from topple.planner.transfer.prediction import after
from topple.planner.transfer.transfer import Transfer, plan_transfer
from topple.robots import robot, shapes
from topple.topology import Scene, Situation

ARM, BASE = robot("panda"), np.eye(4)
BASE[0, 3] = -0.5


def before(now: Situation) -> Iterator[tuple[str, str, str]]:
    """Relations: what has to go before what, and why."""
    yield from ((edge.first, edge.then, edge.reason) for edge in dependencies(now).dependencies)


def grasps(now: Situation, name: str) -> Iterator[Grasp]:
    """Grasps of an object that have room where it is, best first."""
    yield from grasp_candidates(name, now, ARM)


def places(now: Situation, name: str) -> Iterator[Placement]:
    """Free places for it on tops, best first."""
    yield from placements(name, now, pose_base_to_world=BASE)


def motions(now: Situation, name: str, grasp: Grasp, place: Placement, q: np.ndarray) -> Iterator[Transfer]:
    """The certified motions that take it by this grasp to this place; none where there are none."""
    found = plan_transfer(name, now, ARM, BASE, q, [place], grasps=[grasp])
    yield from [found] if isinstance(found, Transfer) else []


def cloud(size: float, bottom: float) -> np.ndarray:
    """The surface of a cube that stands at a height."""
    return shapes.block("cube", size).surface(2000, np.random.default_rng(0)) + np.array([0, 0, bottom])


table = np.random.default_rng(0).uniform(-0.6, 0.6, (5000, 3)) * [1, 1, 0]
clouds = {"table": table, "box": cloud(0.05, 0.0), "block": cloud(0.04, 0.05)}
now, q = Situation(Scene(clouds, fixed=["table"], up=(0, 0, 1))), np.asarray(ARM.home)
for first, then, reason in before(now):
    print(f"(before {first} {then}): {reason}")
for name in ("block", "box"):  # as a planner orders them by those facts
    pairs = product(grasps(now, name), places(now, name))
    step = next(way for grasp, place in pairs for way in motions(now, name, grasp, place, q))
    print(f"{name}: {step.grasp.kind}, {len(step.segments)} segments in {step.seconds:.1f} s")
    now, q = after(now, step), step.q_end
