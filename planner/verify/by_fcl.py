"""Collisions looked for state by state with python-fcl, on the arm's hulls and the objects' convex parts."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.bodies import parts_of, tool_poses
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import BY_FCL_SLACK
from topple.robots.arm.arm import Arm
from topple.robots.collision.fcl_bodies import fcl_body
from topple.topology.base.arrays import FloatArray


@dataclass(eq=False)
class _Piece:
    """A convex part with its fcl object, and what bounds it, in its own frame."""

    name: str
    lower: FloatArray
    upper: FloatArray
    thing: Any

    @property
    def centre(self) -> FloatArray:
        return (self.lower + self.upper) / 2.0

    @property
    def radius(self) -> float:
        return float(np.linalg.norm(self.upper - self.lower)) / 2.0


@dataclass(eq=False)
class FclCheck:
    """Collects what touches what in the segments it is shown.

    Attributes:
        plan: The plan.
        arm: The arm.
    """

    plan: PlanData
    arm: Arm
    touching: Worst = field(default_factory=lambda: Worst("collisions (python-fcl)", "m", BY_FCL_SLACK))
    states: int = 0

    def __post_init__(self) -> None:
        import fcl

        self._fcl: Any = fcl
        self._base = np.array(self.plan.pose_base_to_world)
        self._links = [
            (link, _piece(self.arm.links[link], part))
            for link, parts in enumerate(self.arm.parts)
            for part in parts
            if self.arm.frame_of_link[link] > 0  # what does not move stands where it stands
        ]
        self._objects = {
            name: [_piece(name, part) for part in parts] for name, parts in parts_of(self.plan).items()
        }
        own = {frozenset(pair) for pair in self.arm.self_pairs}
        self._own = [
            (a, b)
            for i, a in enumerate(self._links)
            for b in self._links[:i]
            if frozenset((a[0], b[0])) in own
        ]

    def look(self, driven: SegmentReplay) -> None:
        """Check all states of a segment."""
        self.states += len(driven.states)
        links = np.matmul(self._base, self.arm.forward(driven.states, driven.hand))
        tools = tool_poses(self.arm, self.plan, driven.segment.tool, driven.states)
        allowed = driven.may_touch
        standing = [(piece, pose) for name, pose in driven.poses.items() for piece in self._objects[name]]
        for piece, pose in standing:
            _put(piece, pose)
        for link, piece in self._links:
            poses = links[:, link]
            for other, pose in standing:
                if frozenset((piece.name, other.name)) not in allowed:
                    self._meet(driven, piece, poses, other, pose)
        held = [
            (p, np.matmul(tools, pose)) for name, pose in driven.held.items() for p in self._objects[name]
        ]
        for piece, poses in held:
            carrier = driven.step.object  # what rides in it is checked under its name
            for other, pose in standing:
                if frozenset((carrier, other.name)) not in allowed:
                    self._meet(driven, piece, poses, other, pose)
            for link, part in self._links:
                # the hand moves with what it holds: how they meet was checked on the way in
                if self.arm.frame_of_link[link] < len(self.arm.joints):
                    self._meet_both(driven, part, links[:, link], piece, poses)
        for (a, first), (b, second) in self._own:
            self._meet_both(driven, first, links[:, a], second, links[:, b])

    def residuals(self) -> tuple[Residual, ...]:
        """What was found."""
        return (self.touching.residual(),)

    def _meet(
        self, driven: SegmentReplay, piece: _Piece, poses: FloatArray, other: _Piece, pose: FloatArray
    ) -> None:
        """A moving piece against one that stands (and was put where it stands)."""
        centres = (poses[:, :3, :3] @ piece.centre + poses[:, :3, 3] - pose[:3, 3]) @ pose[:3, :3]
        nearest = np.clip(centres, other.lower, other.upper)
        for k in np.flatnonzero(np.linalg.norm(centres - nearest, axis=1) <= piece.radius).tolist():
            _put(piece, poses[k])
            self._note(driven, piece, other, k)

    def _meet_both(
        self, driven: SegmentReplay, a: _Piece, poses_a: FloatArray, b: _Piece, poses_b: FloatArray
    ) -> None:
        """Two moving pieces."""
        centre_a = poses_a[:, :3, :3] @ a.centre + poses_a[:, :3, 3]
        gap = centre_a - poses_b[:, :3, :3] @ b.centre - poses_b[:, :3, 3]
        for k in np.flatnonzero(np.linalg.norm(gap, axis=1) <= a.radius + b.radius).tolist():
            _put(a, poses_a[k])
            _put(b, poses_b[k])
            self._note(driven, a, b, k)

    def _note(self, driven: SegmentReplay, a: _Piece, b: _Piece, k: int) -> None:
        depth = self._depth(a, b)
        if depth is not None:
            where = f"{driven.where}: {a.name} in {b.name} at state {k} of {len(driven.states)}"
            self.touching.note(depth, where, driven.index)

    def _depth(self, a: _Piece, b: _Piece) -> float | None:
        """How deep two placed pieces are in each other [m]; None where they do not touch."""
        result = self._fcl.CollisionResult()
        request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
        if not self._fcl.collide(a.thing, b.thing, request, result):
            return None
        return max((float(contact.penetration_depth) for contact in result.contacts), default=0.0)


def _piece(name: str, vertices: FloatArray) -> _Piece:
    return _Piece(name, vertices.min(axis=0), vertices.max(axis=0), fcl_body(vertices))


def _put(piece: _Piece, pose: FloatArray) -> None:
    piece.thing.setRotation(np.ascontiguousarray(pose[:3, :3]))
    piece.thing.setTranslation(np.ascontiguousarray(pose[:3, 3]))
