"""What if it were let go here: one simulated world for such questions, kept from one to the next."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from weakref import finalize

import numpy as np

from topple.planner.simulate.lift import move_between
from topple.planner.simulate.tolerances import SECONDS
from topple.robots.engines import rehearsal_world
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.scene.scene import Scene

if TYPE_CHECKING:
    from topple.robots.world.bodies import Body
    from topple.robots.world.physical_world import PhysicalWorld

_Standing = tuple[Sequence[FloatArray], float, FloatArray]
"""Convex parts in the frame of the scene [m], the coefficient of friction, the turn to the world's frame."""


class Sandbox:
    """A world in which one object is let go time and again, among others that hold still or can be pushed.

    It is made once it is needed, and ends with this, or with the block that this is entered for. What stands
    as it stood in the question before stays in it. Another process makes its own.

    Attributes:
        bodies: What the question is about: convex parts of all objects, in the frame of the scene [m].
        body: The object as the world has it, in that frame.
    """

    body: "Body"

    def __init__(self) -> None:
        self.bodies: Solids = {}
        self._worlds: list[PhysicalWorld] = []
        self._still: dict[str, _Standing] = {}
        self._loose: dict[str, FloatArray] = {}

    def __enter__(self) -> "Sandbox":
        return self

    def __exit__(self, *_: object) -> None:
        while self._worlds:
            self._worlds.pop().close()
        self.bodies, self._still = {}, {}

    def __reduce__(self) -> tuple[Any, ...]:
        return Sandbox, ()

    def fill(
        self,
        name: str,
        bodies: Solids,
        up: FloatArray,
        loose: Collection[str] = (),
        scene: Scene | None = None,
    ) -> "Sandbox":
        """Put bodies where they are, and nothing else.

        Args:
            name: The object that will be let go.
            bodies: Convex parts of all objects, in the scene; the others stay where they are.
            up: (3,) unit vector.
            loose: Others that can be pushed; they come to rest before anything is let go.
            scene: Where masses and friction of the objects are given, if anywhere.
        """
        from topple.robots.world.bodies import Body
        from topple.robots.world.tolerances import FRICTION

        known = scene or Scene({name: np.vstack(bodies[name])})
        rough = known.friction

        def add(which: str) -> None:
            mass, centre = known.masses.get(which), known.centres.get(which)
            body = Body.of(which, bodies[which], mass=mass, friction=rough.get(which, FRICTION))
            world.add(body if centre is None else replace(body, centre_of_mass=centre), level)

        world, level = self._world, _level_turn(up)
        still = {
            other: (parts, rough.get(other, FRICTION), level)
            for other, parts in bodies.items()
            if other != name and other not in loose
        }
        for other in world.names:
            if not _same(self._still.get(other), still.get(other)):
                world.remove(other)
        for other, (parts, friction, _) in still.items():
            if other not in world.names:
                world.add(Body.of(other, parts, friction=friction), level, fixed=True)
        for other in (pushed := sorted({*loose} - {name})):
            add(other)
        if pushed:
            world.settle(SECONDS)
        self.bodies, self._still, self._level = bodies, still, level
        self._loose = {other: world.pose(other) for other in pushed}
        add(name)
        self.body = world.body(name)
        return self

    def release(self, pose_before_to_release: FloatArray) -> FloatArray:
        """Let the object go.

        Args:
            pose_before_to_release: (4, 4) rigid transform in the scene from where `bodies` has it.

        Returns:
            (4, 4) rigid transform from there to where it comes to rest, or is after `SECONDS`.
        """
        for other, pose in self._loose.items():
            self._world.place(other, pose)
        self._world.place(self.body.name, self._level @ pose_before_to_release)
        self._world.settle(SECONDS)
        return np.asarray(self._level.T @ self._world.pose(self.body.name), dtype=np.float64)

    def push(self) -> float:
        """How much the last release disturbed what is loose, at most: 1 is as much as counts."""
        world = self._world
        moves = (move_between(world, other, pose, world.pose(other)) for other, pose in self._loose.items())
        return max((move.share for move in moves), default=0.0)

    def way(self, one: FloatArray, other: FloatArray) -> float:
        """How far apart two rigid transforms (4, 4) bring the object's centre of mass [m]."""
        return float(np.linalg.norm((one - other) @ np.append(self.body.centre_of_mass, 1.0)))

    def lowest(self, pose: FloatArray, up: FloatArray) -> float:
        """How high along up (3,) the object's lowest corner is once a rigid transform (4, 4) moved it [m]."""
        return float((np.vstack(self.body.parts) @ pose[:3, :3].T @ up).min() + pose[:3, 3] @ up)

    @property
    def _world(self) -> "PhysicalWorld":
        if not self._worlds:
            self._worlds.append(rehearsal_world())
            finalize(self, self._worlds[0].close)
        return self._worlds[0]


def _same(one: _Standing | None, other: _Standing | None) -> bool:
    if one is None or other is None or one[1] != other[1] or len(one[0]) != len(other[0]):
        return False
    parts = zip((*one[0], one[2]), (*other[0], other[2]), strict=True)
    return all(a is b or np.array_equal(a, b) for a, b in parts)


def _level_turn(up: FloatArray) -> FloatArray:
    """(4, 4) turn that brings up (3,), a unit vector, to z; its transpose is its inverse."""
    axis = np.cross(up, [0.0, 0.0, 1.0])
    pose = np.eye(4)
    if np.linalg.norm(axis) < 1e-9:
        pose[:3, :3] = np.diag([1.0, np.sign(up[2]), np.sign(up[2])])
        return pose
    x = axis / np.linalg.norm(axis)
    pose[:3, :3] = np.stack([x, np.cross(up, x), up])
    return pose
