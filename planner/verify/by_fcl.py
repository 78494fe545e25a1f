"""Collisions looked for state by state with python-fcl, on the arm's hulls and the objects' convex parts."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from topple.planner.verify.replay import Finding, Piece, Replay
from topple.robots.collision.fcl_bodies import fcl_body
from topple.topology.base.arrays import FloatArray


@dataclass(eq=False)
class _Part:
    """A convex part (V, 3) of a link or an object, in its own frame, with its fcl object."""

    name: str
    vertices: FloatArray
    body: Any = field(init=False)

    def __post_init__(self) -> None:
        self.body = fcl_body(self.vertices)
        self.lower, self.upper = self.vertices.min(axis=0), self.vertices.max(axis=0)
        self.centre = (self.lower + self.upper) / 2.0
        self.radius = float(np.linalg.norm(self.upper - self.lower)) / 2.0

    def put(self, pose: FloatArray) -> None:
        """Put it where a pose (4, 4) has it."""
        self.body.setRotation(np.ascontiguousarray(pose[:3, :3]))
        self.body.setTranslation(np.ascontiguousarray(pose[:3, 3]))


def collisions(replay: Replay) -> Iterator[Finding]:
    """How deep links and what they carry are in what they may not touch, and in each other [m]."""
    arm = replay.arm
    links = [
        (link, _Part(arm.links[link], part))
        for link, parts in enumerate(arm.parts)
        for part in parts
        if arm.frame_of_link[link] > 0  # what does not move stands where it stands
    ]
    objects = {name: [_Part(name, part) for part in parts] for name, parts in replay.parts.items()}
    own = {frozenset(pair) for pair in arm.self_pairs}
    pairs = [(a, b) for i, a in enumerate(links) for b in links[:i] if frozenset((a[0], b[0])) in own]
    for piece in replay.pieces:
        poses, allowed = np.matmul(replay.base, arm.forward(piece.states, piece.hand)), piece.may_touch
        tools = replay.tools(piece, piece.states)
        held = [(part, np.matmul(tools, pose)) for name, pose in piece.held.items() for part in objects[name]]
        # what rides in what is carried is checked under its name
        moving = [(part, poses[:, link], part.name) for link, part in links]
        moving += [(part, way, piece.step.object) for part, way in held]
        for name, pose in piece.poses.items():
            for other in objects[name]:
                for part, way, called in moving:
                    if frozenset((called, name)) not in allowed:
                        yield from _meetings(piece, part, way, other, pose[None])
        for link, part in links:
            # the hand moves with what it holds: how they meet was checked on the way in
            if arm.frame_of_link[link] < len(arm.joints):
                for other, way in held:
                    yield from _meetings(piece, part, poses[:, link], other, way)
        for (a, part), (b, other) in pairs:
            yield from _meetings(piece, part, poses[:, a], other, poses[:, b])


def _meetings(
    piece: Piece, a: _Part, poses_a: FloatArray, b: _Part, poses_b: FloatArray
) -> Iterator[Finding]:
    """Where two parts are in each other, with poses (m, 4, 4), or (1, 4, 4) of one that stands."""
    import fcl

    between = poses_a[:, :3, :3] @ a.centre + poses_a[:, :3, 3] - poses_b[:, :3, 3]
    turns = poses_b[:, :3, :3]
    centres = between @ turns[0] if len(turns) == 1 else np.einsum("ki,kij->kj", between, turns)
    away = np.linalg.norm(centres - np.clip(centres, b.lower, b.upper), axis=1)
    for k in np.flatnonzero(away <= a.radius).tolist():
        a.put(poses_a[k])
        b.put(poses_b[min(k, len(poses_b) - 1)])
        result = fcl.CollisionResult()
        if fcl.collide(a.body, b.body, fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), result):
            depth = max((float(contact.penetration_depth) for contact in result.contacts), default=0.0)
            yield piece.finds(depth, f"{a.name} in {b.name} at state {k} of {len(piece.states)}")
