"""A world on MuJoCo: the bodies of a PyBullet world, with another engine's contacts."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.mujoco.engine import mujoco
from topple.robots.mujoco.model import TOUCHING, Blueprint, Shape, weld_name
from topple.robots.mujoco.rolling import Rolling
from topple.robots.mujoco.tolerances import SUBSTEPS
from topple.robots.poses import inverse, pose_from, position_and_quaternion
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import Constraint, Contact, PhysicalWorld, Physics
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput


class MujocoWorld(PhysicalWorld):
    """A MuJoCo simulation of its own, to be used with `with`; z is up.

    Bodies may come and go: the model is compiled anew when the world is next asked for something, and
    everything goes on where it was.

    Attributes:
        drive: Called before every step of the engine, between what depends on where things are and what moves
            them: an arm's motors.
    """

    engine = "mujoco"

    def __init__(self, physics: Physics | None = None) -> None:
        super().__init__(physics)
        self.drive: Callable[[], None] = lambda: None
        self._blueprint = Blueprint(self.physics)
        self._compiled: tuple[Any, Any] | None = None
        self._rolling: Rolling | None = None
        self._shapes: dict[str, Shape] = {}
        self._speeds: dict[str, FloatArray] = {}
        self._joints: dict[str, tuple[float, float]] = {}
        self._next = 0

    def close(self) -> None:
        """End the simulation; more than once does no harm."""
        self._compiled = None

    def add(self, body: Body, pose_body_to_world: FloatArray | None = None, *, fixed: bool = False) -> None:
        """Put a body into the world; see `PhysicalWorld.add`."""
        if body.name in self.ids:
            raise InvalidInput(f"two bodies are called {body.name!r}: give each its own name")
        self._keep()
        pose = np.eye(4) if pose_body_to_world is None else np.array(pose_body_to_world, dtype=float)
        self._blueprint.bodies[body.name] = (body, pose, fixed)
        self.ids[body.name], self._next = self._next, self._next + 1
        self._bodies[body.name] = body
        if fixed:
            self._fixed.add(body.name)

    def _add_floor(self, height: float) -> None:
        self._keep()
        self._blueprint.floors.append(height)

    def put_arm(self, arm: Arm, pose_base_to_world: FloatArray, values: dict[str, float]) -> None:
        """Put an arm into the world.

        Args:
            arm: The arm.
            pose_base_to_world: (4, 4) where it stands.
            values: Of its joints and its hand's, by name [rad] or [m].

        Raises:
            InvalidInput: There is one already.
        """
        if self._blueprint.arm is not None:
            raise InvalidInput("there is an arm in this world: MuJoCo worlds hold one")
        self._keep()
        self._blueprint.arm = arm, pose_base_to_world
        self._joints = {name: (value, 0.0) for name, value in values.items()}

    def remove(self, name: str) -> None:
        """Take a body out of the world."""
        self._number(name)
        self._keep()
        del self.ids[name], self._bodies[name], self._blueprint.bodies[name]
        welds = self._blueprint.welds
        self._blueprint.welds = {pair: how for pair, how in welds.items() if pair[0] != name}
        self._fixed.discard(name)

    def pose(self, name: str) -> FloatArray:
        """(4, 4) pose_body_to_world of a body."""
        self._number(name)
        if name in self._fixed or self._compiled is None:
            return self._blueprint.bodies[name][1].copy()
        at = self._address(name)[0]
        x, y, z, qw, qx, qy, qz = self._compiled[1].qpos[at : at + 7].tolist()
        return pose_from((x, y, z), (qx, qy, qz, qw))

    def place(self, name: str, pose_body_to_world: FloatArray, rising: float = 0.0) -> None:
        """Set a body somewhere; see `PhysicalWorld.place`."""
        self._number(name)
        if name in self._fixed or self._compiled is None:
            self._keep()
            body, _, fixed = self._blueprint.bodies[name]
            self._blueprint.bodies[name] = (body, np.array(pose_body_to_world, dtype=float), fixed)
            self._speeds[name] = np.array([0.0, 0.0, rising, 0.0, 0.0, 0.0])
            return
        position, (x, y, z, w) = position_and_quaternion(pose_body_to_world)
        at, speed = self._address(name)
        self._compiled[1].qpos[at : at + 7] = [*position, w, x, y, z]
        self._compiled[1].qvel[speed : speed + 6] = [0.0, 0.0, rising, 0.0, 0.0, 0.0]

    def clamp(self, name: str) -> Callable[[], None]:
        """Keep a body where it is, whatever pulls; see `PhysicalWorld.clamp`."""
        middle = self.pose(name) @ np.append(self.body(name).centre_of_mass, 1.0)
        self.weld(name, None, middle[:3])
        return partial(self.unweld, name, None)

    def step(self, count: int = 1) -> None:
        """Advance the simulation by `count` time steps."""
        model, data = self.state
        assert self._rolling is not None
        for _ in range(count * SUBSTEPS):
            mujoco.mj_step1(model, data)
            self.drive()
            mujoco.mj_step2(model, data)
            self._rolling.after_step(data)
        mujoco.mj_kinematics(model, data)
        self.time += count * self.time_step

    def speeds(self, name: str) -> tuple[float, float]:
        """Speed in [m/s] and turning speed in [rad/s] of a body."""
        _, data = self.state
        at = self._address(name)[1]
        return float(np.linalg.norm(data.qvel[at : at + 3])), float(
            np.linalg.norm(data.qvel[at + 3 : at + 6])
        )

    def contacts(self) -> list[Contact]:
        """Everything that touched in the last step, robots and the floor left out."""
        found: list[Contact] = []
        for a, b, point, normal, force, distance in self.touches():
            if not (a.robot or b.robot) and a.owner and b.owner and distance <= TOLERANCES.contact:
                found.append(Contact(a.owner, b.owner, point, normal, force, distance))
        return found

    def constraints(self) -> tuple[Constraint, ...]:
        """Everything that ties bodies together."""
        arm = self._blueprint.arm
        jaw = None if arm is None else arm[0].jaw
        gears = () if jaw is None else jaw.joints[1:]
        ties = [("gear", "robot", "robot") for _ in gears]
        held = self._blueprint.welds
        ties += [("fixed", "world" if link is None else "robot", name) for name, link in held]
        return tuple(Constraint(*tie, np.inf) for tie in ties)

    def touches(self) -> list[tuple[Shape, Shape, FloatArray, FloatArray, float, float]]:
        """Contacts of the last step: shapes a and b, point, normal from b to a, force [N], distance [m]."""
        model, data = self.state
        found: list[tuple[Shape, Shape, FloatArray, FloatArray, float, float]] = []
        force = np.zeros(6)
        for k in range(data.ncon):
            contact = data.contact[k]
            first, second = (self._shapes.get(model.geom(int(g)).name) for g in contact.geom)
            if first is None or second is None:
                continue
            mujoco.mj_contactForce(model, data, k, force)
            normal = -np.array(contact.frame[:3])  # MuJoCo's points from the first to the second
            pressed = float(force[0])
            found.append((first, second, np.array(contact.pos), normal, pressed, float(contact.dist)))
        return found

    def ray_hit(self, start: FloatArray, end: FloatArray, link: str) -> tuple[str | None, float]:
        """Cast a ray from one point (3,) to another and find the first body it meets.

        Args:
            start: In the world [m].
            end: Likewise.
            link: A link of the arm that it passes through.

        Returns:
            The body, and the share of the way until it; None and 1 where there is none.
        """
        model, data = self.state
        way, geom = end - start, np.zeros(1, dtype=np.int32)
        groups = np.array([k == TOUCHING for k in range(mujoco.mjNGROUP)], dtype=np.uint8)
        passed = model.body(f"robot {link}").id
        far = mujoco.mj_ray(model, data, start, way, groups, 1, passed, geom, None)
        shape = self._shapes.get(model.geom(int(geom[0])).name) if 0.0 <= far <= 1.0 else None
        return (shape.owner, float(far)) if shape is not None and not shape.robot else (None, 1.0)

    def weld(self, name: str, link: str | None, point: FloatArray) -> None:
        """Hold a body, as it is, to a link of the arm or, where None, to the world.

        Args:
            name: The body.
            link: The link.
            point: (3,) where, in the world [m].
        """
        to = np.eye(4)
        if link is not None:
            body = self.state[1].body(f"robot {link}")
            to[:3, :3], to[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        pose = self.pose(name)
        self._keep()
        there = inverse(pose)
        self._blueprint.welds[name, link] = inverse(to) @ pose, there[:3, :3] @ point + there[:3, 3]

    def unweld(self, name: str, link: str | None) -> None:
        """Let go of a body; nothing happens where it is not held so."""
        if self.is_welded(name, link):
            self._keep()
            del self._blueprint.welds[name, link]

    def is_welded(self, name: str, link: str | None) -> bool:
        """Whether a body is held to a link, or to the world."""
        return (name, link) in self._blueprint.welds

    def weld_wrench(self, name: str, link: str | None) -> tuple[FloatArray, FloatArray]:
        """Force (3,) [N] of a weld on its body in the last step, and moment (3,) [N m] about its middle."""
        model, data = self.state
        weld = model.equality(weld_name(name, link)).id
        own = (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (data.efc_id == weld)
        exerted = np.zeros(model.nv)
        mujoco.mj_mulJacTVec(model, data, exerted, np.where(own, data.efc_force, 0.0))
        at = self._address(name)[1]
        force, turn = exerted[at : at + 3], self.pose(name)[:3, :3]
        middle = turn @ self.body(name).centre_of_mass
        return force, turn @ exerted[at + 3 : at + 6] - np.cross(middle, force)

    @property
    def state(self) -> tuple[Any, Any]:
        """MuJoCo's model and data."""
        if self._compiled is None:
            model, self._shapes = self._blueprint.compile_model(self.time_step / SUBSTEPS)
            data: Any = mujoco.MjData(model)
            self._compiled = model, data
            for name, speed in self._speeds.items():
                if name in self.movable:
                    at = self._address(name)[1]
                    data.qvel[at : at + 6] = speed
            for name, (value, speed) in self._joints.items():
                joint = self.joint(name)
                if joint is not None:
                    data.qpos[joint[0]], data.qvel[joint[1]] = value, speed
            mujoco.mj_forward(model, data)
            turning = {name: self._address(name)[1] + 3 for name in self.movable}
            self._rolling = Rolling(model, self._shapes, turning)
            self._rolling.after_step(data)
        return self._compiled

    def joint(self, name: str) -> tuple[int, int] | None:
        """Where the value and the speed of an arm's joint are; None where it does not move."""
        model, _ = self.state
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"robot {name}")
        return None if number < 0 else (int(model.jnt_qposadr[number]), int(model.jnt_dofadr[number]))

    def _address(self, name: str) -> tuple[int, int]:
        """Where the pose and the speed of a body are."""
        model, _ = self.state
        joint = model.joint(name)
        return int(joint.qposadr[0]), int(joint.dofadr[0])

    def _keep(self) -> None:
        """Write down where everything is, before the model is compiled anew."""
        if self._compiled is None:
            return
        _, data = self._compiled
        for name in self.movable:
            body, _, fixed = self._blueprint.bodies[name]
            at = self._address(name)[1]
            self._speeds[name] = np.array(data.qvel[at : at + 6])
            self._blueprint.bodies[name] = (body, self.pose(name), fixed)
        for name in self._joints:
            joint = self.joint(name)
            if joint is not None:
                self._joints[name] = float(data.qpos[joint[0]]), float(data.qvel[joint[1]])
        self._compiled = None
