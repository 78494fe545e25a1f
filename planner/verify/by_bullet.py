"""Collisions looked for with PyBullet: its kinematics, its hulls of the arm's meshes, its narrow phase."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.bodies import parts_of
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import BY_BULLET_SLACK, DEEPER, FILLED
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName
from topple.robots.engine import pybullet
from topple.robots.poses import position_and_quaternion
from topple.topology.base.arrays import FloatArray

# noisy clouds slide along each other's facets


@dataclass(eq=False)
class BulletCheck:
    """A world of its own with the arm and every object, to be used with `with`.

    Attributes:
        plan: The plan.
        arm: The arm.
    """

    plan: PlanData
    arm: Arm
    touching: Worst = field(default_factory=lambda: Worst("collisions (PyBullet)", "m", BY_BULLET_SLACK))
    deeper: Worst = field(default_factory=lambda: Worst("touching bodies pressed deeper", "m", DEEPER))
    strayed: Worst = field(default_factory=lambda: Worst("kinematics against PyBullet", "m", 1e-4))

    def __enter__(self) -> "BulletCheck":
        self._fixed = {thing.name for thing in self.plan.objects if thing.fixed}
        self._client: int = pybullet.connect(pybullet.DIRECT)
        base = position_and_quaternion(np.array(self.plan.pose_base_to_world))
        self._robot: int = pybullet.loadURDF(
            str(self.arm.urdf), *base, useFixedBase=True, physicsClientId=self._client
        )
        self._names: dict[int, str] = {}
        self._joints: dict[str, int] = {}
        for index in range(pybullet.getNumJoints(self._robot, physicsClientId=self._client)):
            info: Any = pybullet.getJointInfo(self._robot, index, physicsClientId=self._client)
            self._names[index], self._joints[info[1].decode()] = info[12].decode(), index
            pybullet.changeDynamics(self._robot, index, collisionMargin=0.0, physicsClientId=self._client)
        self._bodies = {
            name: [self._body(part) for part in parts] for name, parts in parts_of(self.plan).items()
        }
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pybullet.disconnect(physicsClientId=self._client)

    def look(self, piece: SegmentReplay) -> None:
        """Check the states of a segment."""
        for name, pose in piece.poses.items():
            self._put(name, pose)
        allowed = piece.may_touch
        tool = self.arm.tools[piece.segment.tool]
        pressed: dict[str, list[float]] = {}
        for k, q in enumerate(piece.states):
            self._stand(q, piece)
            link = self._link_pose(tool.link) @ tool.pose_tool_to_link
            computed = np.array(self.plan.pose_base_to_world) @ self.arm.tool_pose(q, tool.name)[0]
            stray = float(np.abs(link - computed).max()) if tool.name == ToolName.FINGERS else 0.0
            self.strayed.note(stray, f"{piece.where}: {tool.name} at state {k}", piece.index)
            for name, to_tool in piece.held.items():
                self._put(name, computed @ to_tool)
            where = f"{piece.where}: {{}} in {{}} at state {k} of {len(piece.states)} of PyBullet"
            for name in piece.poses:
                for body in self._bodies[name]:
                    self._arm_against(piece, body, name, where)
                depth = self._depth(piece.held, name) if piece.held else 0.0
                if frozenset((piece.step.object, name)) not in allowed:
                    self.touching.note(depth, where.format(piece.step.object, name), piece.index)
                elif piece.step.placement.into != name:  # let down into a hollow: seen points decide there
                    pressed.setdefault(name, []).append(depth)
        for name, depths in pressed.items():
            rest = depths[piece.at_rest]
            if rest > FILLED and name not in self._fixed:  # in a hollow that a hull fills: seen points decide
                continue
            against = f"{piece.where}: {piece.step.object} against {name}"
            self.deeper.note(max(depths) - rest, against, piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found."""
        return self.touching.residual(), self.deeper.residual(), self.strayed.residual()

    def _arm_against(self, piece: SegmentReplay, body: int, name: str, where: str) -> None:
        for contact in pybullet.getClosestPoints(self._robot, body, 0.0, physicsClientId=self._client):
            link = self._names.get(contact[3], "base")
            moves = link in self.arm.links and self.arm.frame_of_link[self.arm.links.index(link)] > 0
            if moves and frozenset((link, name)) not in piece.may_touch:
                self.touching.note(-float(contact[8]), where.format(link, name), piece.index)

    def _depth(self, held: dict[str, FloatArray], name: str) -> float:
        """How deep what is held is in another object [m]; python-fcl's depths of hulls come out too small."""
        deepest = 0.0
        for carried in held:
            for own in self._bodies[carried]:
                for body in self._bodies[name]:
                    found: Sequence[Any] = pybullet.getClosestPoints(
                        own, body, 0.0, physicsClientId=self._client
                    )
                    deepest = max([deepest, *(-float(contact[8]) for contact in found)])
        return deepest

    def _body(self, part: FloatArray) -> int:
        shape: int = pybullet.createCollisionShape(
            pybullet.GEOM_MESH, vertices=part.tolist(), physicsClientId=self._client
        )
        body: int = pybullet.createMultiBody(0.0, shape, physicsClientId=self._client)
        pybullet.changeDynamics(body, -1, collisionMargin=0.0, physicsClientId=self._client)
        return body

    def _put(self, name: str, pose: FloatArray) -> None:
        place = position_and_quaternion(pose)
        for body in self._bodies[name]:
            pybullet.resetBasePositionAndOrientation(body, *place, physicsClientId=self._client)

    def _stand(self, q: FloatArray, piece: SegmentReplay) -> None:
        for name, value in self.arm.joint_values(q, piece.hand).items():
            pybullet.resetJointState(self._robot, self._joints[name], value, physicsClientId=self._client)

    def _link_pose(self, link: str) -> FloatArray:
        index = next(number for number, name in self._names.items() if name == link)
        state: Any = pybullet.getLinkState(
            self._robot, index, computeForwardKinematics=True, physicsClientId=self._client
        )
        pose = np.eye(4)
        pose[:3, :3] = np.array(pybullet.getMatrixFromQuaternion(state[5])).reshape(3, 3)
        pose[:3, 3] = state[4]
        return pose
