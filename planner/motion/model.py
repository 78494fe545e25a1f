"""What can hit what: the arm's links, what it holds, and the obstacles, as convex parts with their pairs."""

from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import FINGERS, ToolState
from topple.robots.collision.convex import hull_of
from topple.robots.collision.separation import ConvexSets
from topple.robots.poses import inverse
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.solids import Solids
from topple.topology.geometry.rigid import move_points


@dataclass(frozen=True, eq=False)
class Attachment:
    """An object in the hand.

    Attributes:
        parts: Vertex sets (V, 3) of its convex parts in the tool frame in [m].
        tool: The tool that holds it.
        name: Its name.
    """

    parts: tuple[FloatArray, ...]
    tool: str = FINGERS
    name: str = "held"


@dataclass(frozen=True, eq=False)
class CollisionModel:
    """All parts and the pairs to check.

    Attributes:
        names: Per part the name of its link or object.
        vertices: Per part its (V, 3) vertices in the frame that carries it in [m]; frame 0 is the arm's base.
        sets: The same parts prepared for batches.
        moving: (M,) indices of the parts that move.
        standing: (S,) indices of the parts that do not.
        standing_pairs: (M, S) which moving parts are checked against which standing ones.
        moving_pairs: (K, 2) part indices of the moving parts checked against each other, the one nearer the
            base first.
        margin: (P,) wanted distance in [m] of each part from others; 0 for links and what is held, and
            between them.
        obstacle: (P,) which parts belong to obstacles.
    """

    names: tuple[str, ...]
    vertices: tuple[FloatArray, ...]
    sets: ConvexSets
    moving: IntArray
    standing: IntArray
    standing_pairs: BoolArray
    moving_pairs: IntArray
    margin: FloatArray
    obstacle: BoolArray

    @staticmethod
    def of(
        arm: Arm,
        pose_base_to_world: FloatArray,
        obstacles: Solids,
        tool_state: ToolState,
        attached: Attachment | None,
        allow: Collection[frozenset[str]],
        margin: float,
    ) -> "CollisionModel":
        """Collect parts and pairs; see `Checker` for the arguments.

        Raises:
            InvalidInput: If an obstacle has no points or ones that are not finite, or shares a link's name.
        """
        parts = _Parts([], [], [], [])
        parts.add_links(arm, tool_state)
        if attached is not None:
            parts.add_attached(arm, attached)
        robot = len(parts.names)
        parts.add_obstacles(pose_base_to_world, obstacles, taken=set(parts.names))
        frame = np.array(parts.frames, dtype=np.int64)
        moving = np.flatnonzero(frame > 0)
        standing = np.flatnonzero(frame == 0)
        checked = parts.checked_pairs(arm, robot, set(allow))
        both = [(i, j) for i, j in checked if frame[i] > 0 and frame[j] > 0]
        both = [(i, j) if frame[i] <= frame[j] else (j, i) for i, j in both]
        table = np.zeros((len(parts.names), len(parts.names)), dtype=np.bool_)
        for i, j in checked:
            table[i, j] = table[j, i] = True
        return CollisionModel(
            tuple(parts.names),
            tuple(parts.vertices),
            ConvexSets.of(parts.vertices, parts.frames),
            moving,
            standing,
            table[np.ix_(moving, standing)],
            np.array(both, dtype=np.int64).reshape(-1, 2),
            np.where(np.arange(len(parts.names)) >= robot, margin, 0.0),
            np.arange(len(parts.names)) >= robot,
        )


@dataclass
class _Parts:
    names: list[str]
    vertices: list[FloatArray]
    frames: list[int]
    links: list[int]  # index of the link; -1 for what is held, -2 for obstacles

    def add_links(self, arm: Arm, tool_state: ToolState) -> None:
        offsets = arm.offsets(tool_state)
        for i, (link, parts) in enumerate(zip(arm.links, arm.parts, strict=True)):
            for part in parts:
                self._add(link, move_points(part, offsets[i]), arm.frame_of_link[i], i)

    def add_attached(self, arm: Arm, attached: Attachment) -> None:
        pose = arm.tool_to_flange(attached.tool)
        for part in attached.parts:
            self._add(attached.name, move_points(_check_part(part, attached.name), pose), len(arm.joints), -1)

    def add_obstacles(self, pose_base_to_world: FloatArray, obstacles: Solids, taken: set[str]) -> None:
        world_to_base = inverse(pose_base_to_world)
        for name, obstacle in obstacles.items():
            if name in taken:
                raise InvalidInput(
                    f"the obstacle {name!r} has the name of a link or of what is held; rename it"
                )
            for part in obstacle:
                self._add(name, move_points(_check_part(part, name), world_to_base), 0, -2)

    def _add(self, name: str, vertices: FloatArray, frame: int, link: int) -> None:
        self.names.append(name)
        self.vertices.append(vertices)
        self.frames.append(frame)
        self.links.append(link)

    def checked_pairs(self, arm: Arm, robot: int, allow: set[frozenset[str]]) -> list[tuple[int, int]]:
        own = {frozenset(pair) for pair in arm.self_pairs}
        pairs: list[tuple[int, int]] = []
        for i in range(robot):
            for j in range(i + 1, len(self.names)):
                if frozenset((self.names[i], self.names[j])) in allow:
                    continue
                if j >= robot:
                    wanted = self.frames[i] > 0  # the base stands where it stands
                elif self.links[j] == -1:
                    wanted = self.links[i] >= 0 and self.frames[i] < self.frames[j]
                else:
                    wanted = frozenset((self.links[i], self.links[j])) in own
                if wanted:
                    pairs.append((i, j))
        return pairs


def _check_part(part: FloatArray, name: str) -> FloatArray:
    """Hull vertices of a part that came from outside."""
    points: FloatArray = np.asarray(part, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.isfinite(points).all():
        raise InvalidInput(f"{name!r}: expected finite points (V, 3), found an array {points.shape}")
    return _hull_vertices(points.tobytes())


@lru_cache(maxsize=4096)  # an object's parts come again with every checker of its scene
def _hull_vertices(data: bytes) -> FloatArray:
    return freeze(hull_of(np.frombuffer(data).reshape(-1, 3))[0])
