"""An arm in a world on MuJoCo: joints with computed torques, fingers that hold by friction, a vacuum cup."""

from collections.abc import Sequence

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.urdf import urdf_root
from topple.robots.mujoco.engine import mujoco
from topple.robots.mujoco.tolerances import CLOSING, MOST_PUSH, PUSHING, STIFFNESS
from topple.robots.mujoco.vacuum import MujocoVacuum
from topple.robots.mujoco.world import MujocoWorld
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.touch import note_touches
from topple.robots.world.vacuum import Vacuum
from topple.robots.world.wrist import Wrist
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray


@checked_arguments
class MujocoArm(ActingArm):
    """An `ActingArm` at home in a world on MuJoCo; gains are those of `topple.robots.mujoco.tolerances`."""

    def __init__(
        self, world: MujocoWorld, arm: Arm, pose_base_to_world: FloatArray, q: FloatArray | None = None
    ) -> None:
        super().__init__(arm, pose_base_to_world, q)
        self._world = world
        world.arms.append(self)
        world.put_arm(arm, self.pose_base_to_world, arm.joint_values(self.q_target, self.tool_state))
        self._efforts = {
            str(joint.get("name")): float(limit.get("effort") or 0.0) or np.inf
            for joint in urdf_root(arm.urdf).findall("joint")
            if (limit := joint.find("limit")) is not None
        }
        self._goal = self.q_target.copy(), np.zeros(len(arm.joints))
        self.wrist = Wrist(self._loads, arm, world.physics.gravity, world.time_step)
        world.drive = self._motors

    @property
    def world(self) -> MujocoWorld:
        """The world it stands in."""
        return self._world

    def joint_positions(self, names: Sequence[str]) -> FloatArray:
        """Measured values of some joints in [rad] or [m]."""
        _, data = self.world.state
        return np.array([data.qpos[self._at(name)[0]] for name in names])

    def efforts(self, names: Sequence[str]) -> Sequence[float]:
        """Efforts of the motors of some joints of the hand in [N m] or [N]."""
        _, data = self.world.state
        return [float(data.actuator(f"robot {name}").force[0]) for name in names]

    def _vacuum_on(self, cup: SuctionCup, pose_lip_to_world: FloatArray) -> Vacuum | None:
        return MujocoVacuum.on(self.world, cup.link, pose_lip_to_world, cup)

    def on_pads(self) -> tuple[FloatArray, FloatArray]:
        """Where something presses on the pads (k, 3) in [m], and how (k, 3) in [N], in the world."""
        pads = self.jaw.links if self.jaw else ()
        places, forces = list[FloatArray](), list[FloatArray]()
        for a, b, point, normal, force, _ in self.world.touches():
            for own, sign in ((a, 1.0), (b, -1.0)):
                if own.robot and own.owner in pads:
                    places.append(point)
                    forces.append(sign * force * normal)
        return np.array(places).reshape(-1, 3), np.array(forces).reshape(-1, 3)

    def link_pose(self, link: str) -> FloatArray:
        """(4, 4) measured pose of a link's frame in the world."""
        _, data = self.world.state
        body = data.body(f"robot {link}")
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        return pose

    def _at(self, joint: str) -> tuple[int, int]:
        found = self.world.joint(joint)
        assert found is not None
        return found

    def _drive(self, q: FloatArray, v: FloatArray) -> None:
        self._goal = q, v

    def _motors(self) -> None:
        """Torques of the arm for where it is to be, within its limits, and speeds of the fingers."""
        model, data = self.world.state
        q, v = self._goal
        places = np.array([self._at(name) for name in self.arm.joints])
        dofs = places[:, 1]
        wanted = np.zeros(model.nv)
        wanted[dofs] = STIFFNESS**2 * (q - data.qpos[places[:, 0]]) + 2.0 * STIFFNESS * (v - data.qvel[dofs])
        torques = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, torques, wanted)
        torques += data.qfrc_bias - data.qfrc_passive
        most = np.array([self._efforts.get(name, np.inf) for name in self.arm.joints])
        data.ctrl[: len(most)] = np.clip(torques[dofs], -most, most)
        if self.jaw is not None:
            share = 2.0 * self._grip_force / len(self.jaw.joints)  # all joints together press both pads
            for name, value in self.jaw.values(self.tool_state).items():
                lever = self.jaw.lever(name)
                self._press(name, value, share * lever, self.jaw.speed / 2.0 / lever, CLOSING)
        if self.cup is not None:
            push = self.control.seating if self.vacuum is None else np.inf
            for name, value in self.cup.values(self.tool_state).items():
                most = self._efforts.get(name, np.inf)
                force = min(push, most if np.isfinite(most) else MOST_PUSH)
                self._press(name, value, force, self.cup.speed, PUSHING)

    def _press(self, joint: str, value: float, force: float, speed: float, rate: float) -> None:
        """Drive a joint of the hand to a value; held up, it presses with its whole force."""
        model, data = self.world.state
        motor = model.actuator(f"robot {joint}")
        motor.gainprm[0], motor.biasprm[2] = force / speed, -force / speed
        short = value - data.qpos[self._at(joint)[0]]
        data.actuator(f"robot {joint}").ctrl[0] = np.clip(rate * short, -speed, speed)

    def _loads(self, still: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Values, speeds and what contacts take of the torques (n,) of the arm's joints."""
        _, data = self.world.state
        places = np.array([self._at(name) for name in self.arm.joints])
        return data.qpos[places[:, 0]], data.qvel[places[:, 1]], -data.qfrc_constraint[places[:, 1]]

    def _advance(self) -> None:
        self.world.step()
        if self.vacuum is not None:
            self.vacuum.check()
        contacts = [
            (other.owner, own.owner, force)
            for a, b, _, _, force, _ in self.world.touches()
            for own, other in ((a, b), (b, a))
            if own.robot and not other.robot and other.owner and force > 0.0
        ]
        note_touches(self.touched, contacts, self.world.time_step)
        for watch in self.on_step:
            watch()
