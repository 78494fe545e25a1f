"""Seeded motion problems to measure with: picks in clutter, and transfers around a wall."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.robots.arm.shapes import prism
from topple.robots.poses import pose_from
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points


@dataclass(frozen=True, eq=False)
class Solid:
    """A box, cylinder or sphere.

    Attributes:
        kind: Which of them.
        size: Edges of a box, length and radius of a cylinder, radius of a sphere [m].
        pose: (4, 4) of its middle, in the arm's base; a cylinder is along z.
    """

    kind: str
    size: Sequence[float]
    pose: FloatArray

    @property
    def corners(self) -> FloatArray:
        """(V, 3) in [m], of a body around it at most 2 % wider."""
        import trimesh

        if self.kind == "box":
            corners = trimesh.creation.box(self.size).vertices
        elif self.kind == "cylinder":
            corners = prism(self.size[1], self.size[0])
        else:  # an icosphere lies inside the ball: scaled so that its faces do not
            corners = trimesh.creation.icosphere(subdivisions=2, radius=1.02 * self.size[0]).vertices
        return move_points(np.asarray(corners, dtype=float), self.pose)


Solids = Mapping[str, Solid]


@dataclass(frozen=True, eq=False)
class Problem:
    """One query.

    Attributes:
        boxes: What stands around the arm.
        checker: The arm among them.
        start: (n,) free joint values.
        goals: (g, n) free joint values, the nearest to the start first.
    """

    boxes: Solids
    checker: Checker
    start: FloatArray
    goals: FloatArray


def pick(arm: Arm, seed: int) -> Problem:
    """From the home state to a top-down pose low between eight boxes on a table."""
    rng = np.random.default_rng(seed)
    boxes = clutter(rng, 8)
    checker = checker_of(arm, boxes)
    return _problem(boxes, checker, arm.home, _reachable(checker, rng, 0.0, 0.15))


def transfer(arm: Arm, seed: int) -> Problem:
    """From one side of a wall on the table to the other, between four boxes; no straight edge is free."""
    rng = np.random.default_rng(seed)
    boxes = clutter(rng, 4) | {"wall": box((0.45, 0.0, 0.25), (0.5, 0.04, 0.5))}
    checker = checker_of(arm, boxes)
    while True:
        start, goals = _reachable(checker, rng, 0.3, 0.1)[0], _reachable(checker, rng, -0.3, 0.1)
        if not checker.edges_free(np.broadcast_to(start, goals.shape), goals).any():
            return _problem(boxes, checker, start, goals)


def checker_of(arm: Arm, boxes: Solids) -> Checker:
    """A fresh checker of an arm among boxes."""
    return Checker(arm, np.eye(4), {name: [box.corners] for name, box in boxes.items()})


def clutter(rng: np.random.Generator, count: int) -> dict[str, Solid]:
    """A table with boxes of 4 to 20 cm on it."""
    boxes = {"table": box((0.5, 0.0, -0.03), (1.2, 1.6, 0.04))}
    for k in range(count):
        x, y, z = (float(v) for v in rng.uniform(0.04, 0.2, 3))
        place = (float(rng.uniform(0.3, 0.75)), float(rng.uniform(-0.6, 0.6)), z / 2)
        boxes[f"box {k}"] = box(place, (x, y, z), float(rng.uniform(0, np.pi)))
    return boxes


def box(centre: Sequence[float], size: Sequence[float], yaw: float = 0.0) -> Solid:
    """A box of some edges [m], turned about the vertical by an angle [rad]."""
    return Solid("box", size, pose_from(centre, [0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)]))


def top_down(x: float, y: float, z: float, yaw: float) -> FloatArray:
    """(4, 4) pose of a tool that points straight down."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, s, 0, x], [s, -c, 0, y], [0, 0, -1, z], [0, 0, 0, 1]])


def _problem(boxes: Solids, checker: Checker, start: FloatArray, goals: FloatArray) -> Problem:
    nearest = np.argsort(np.linalg.norm(goals - start, axis=1), kind="stable")
    return Problem(boxes, checker, start, goals[nearest])


def _reachable(checker: Checker, rng: np.random.Generator, side: float, spread: float) -> FloatArray:
    """Free states for a random top-down pose about as far out on a side."""
    while True:
        x, y = rng.uniform(0.35, 0.6), side + rng.uniform(-spread, spread)
        pose = top_down(float(x), float(y), float(rng.uniform(0.05, 0.2)), float(rng.uniform(-1.5, 1.5)))
        states = checker.arm.inverse(pose, seeds=32, rng=rng)[0]
        states = states[checker.free(states)] if len(states) else states
        if len(states):
            return states[:8]
