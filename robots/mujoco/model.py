"""MuJoCo's model of a world, from the parts that plans are checked with."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.mujoco.engine import mujoco
from topple.robots.mujoco.tolerances import FINGER_ROTOR, GRIP, HARD, NO_SLIP, ROTOR, SQUARE, STIFF
from topple.robots.poses import position_and_quaternion
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import Physics, principal_axes
from topple.robots.world.tolerances import FRICTION, LINK_FRICTION
from topple.robots.world.touch import combined_friction
from topple.topology.base.arrays import FloatArray

TOUCHING, FLOOR = 3, 4
"""Groups of shapes: what collides, and the floor, which does but is felt by no ray."""


@dataclass(frozen=True)
class Shape:
    """A shape that collides.

    Attributes:
        name: Its name in the model.
        owner: The body or the link it belongs to.
        moves: Whether it can move.
        robot: Whether it is an arm's.
        frictions: (3,) Coulomb coefficient, levers of what resists spinning about the normal and rolling [m].
    """

    name: str
    owner: str
    moves: bool
    robot: bool
    frictions: FloatArray


@dataclass
class Blueprint:
    """What a world holds, to be compiled.

    Attributes:
        physics: Gravity, time step.
        bodies: Name -> body, where it stands (4, 4), whether it never moves.
        floors: Heights of floors [m].
        arm: The arm and the pose (4, 4) of its base, if there is one.
        welds: Body and link, None for the world -> pose (4, 4) of the body in the link, and the point (3,) of
            the body that it is held at.
    """

    physics: Physics
    bodies: dict[str, tuple[Body, FloatArray, bool]] = field(
        default_factory=dict[str, tuple[Body, FloatArray, bool]]
    )
    floors: list[float] = field(default_factory=list[float])
    arm: tuple[Arm, FloatArray] | None = None
    welds: dict[tuple[str, str | None], tuple[FloatArray, FloatArray]] = field(
        default_factory=dict[tuple[str, str | None], tuple[FloatArray, FloatArray]]
    )

    def compile_model(self, time_step: float) -> tuple[Any, dict[str, Shape]]:
        """MuJoCo's model, and what collides in it by name.

        Args:
            time_step: Of the engine [s].
        """
        spec: Any = mujoco.MjSpec()
        spec.compiler.boundmass, spec.compiler.boundinertia = 1e-3, 1e-7
        spec.compiler.degree = False
        option = spec.option
        option.timestep, option.gravity = time_step, [0.0, 0.0, -self.physics.gravity]
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        option.impratio, option.noslip_iterations = GRIP, NO_SLIP
        # several contacts of two hulls: before MuJoCo 4 they have to be asked for, and faces rock without
        option.enableflags |= int(getattr(mujoco.mjtEnableBit, "mjENBL_MULTICCD", 0))
        shapes: list[Shape] = []
        for k, height in enumerate(self.floors):
            plane = spec.worldbody.add_geom(
                name=f"floor {k}", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5.0, 5.0, 0.1],
                pos=[0.0, 0.0, height], group=FLOOR, contype=0, conaffinity=0,
            )  # fmt: skip
            shapes.append(Shape(plane.name, "", False, False, np.array([FRICTION, 0.0, 0.0])))
        for body, pose, fixed in self.bodies.values():
            shapes += _add_body(spec, body, pose, fixed)
        if self.arm is not None:
            shapes += _add_arm(spec, *self.arm)
        for (name, link), (pose, point) in self.welds.items():
            _add_weld(spec, name, link, pose, point)
        held = {frozenset(pair) for pair in self.welds}  # what presses there is the weld's to say
        for a, b in combinations(shapes, 2):
            beside = a.owner != b.owner and not (a.robot and b.robot)
            if beside and (a.moves or b.moves) and frozenset((a.owner, b.owner)) not in held:
                _add_pair(spec, a, b)
        return spec.compile(), {shape.name: shape for shape in shapes}


def _add_pair(spec: Any, a: Shape, b: Shape) -> None:
    """Set the contact of two shapes as PyBullet has it; see `topple.robots.mujoco.rolling`, too."""
    slide, spin, roll = combined_friction(a.frictions, b.frictions)
    spec.add_pair(
        geomname1=a.name, geomname2=b.name, condim=6 if a.robot or b.robot else 3,
        friction=[slide, slide, spin, roll, roll], solref=STIFF, solimp=HARD,
    )  # fmt: skip


def _add_weld(spec: Any, name: str, link: str | None, pose: FloatArray, point: FloatArray) -> None:
    """Hold a body to a link, or to the world, as it is."""
    _, quaternion = _position_and_quaternion(pose)
    weld = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_WELD, name=weld_name(name, link), objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1="world" if link is None else f"robot {link}", name2=name, solref=STIFF, solimp=HARD,
    )  # fmt: skip
    weld.data[:] = 0.0
    weld.data[:11] = [
        *point,
        *(pose[:3, :3] @ point + pose[:3, 3]),
        *quaternion,
        1.0,
    ]  # the point, seen from both


def weld_name(name: str, link: str | None) -> str:
    """Name the weld of a body to a link, or to the world, in the model."""
    return f"weld {name} {'' if link is None else link}"


def _add_body(spec: Any, body: Body, pose: FloatArray, fixed: bool) -> list[Shape]:
    position, quaternion = _position_and_quaternion(pose)
    added = spec.worldbody.add_body(name=body.name, pos=position, quat=quaternion)
    if not fixed:
        added.add_freejoint(name=body.name)
        moments, inertial = principal_axes(body)
        added.explicitinertial = True
        added.mass, added.inertia = body.mass, moments
        added.ipos, added.iquat = _position_and_quaternion(inertial)
    shapes: list[Shape] = []
    for k, part in enumerate(body.parts):
        name = f"{body.name} {k}"
        _add_part(spec, added, name, part, TOUCHING)
        frictions = np.array([body.friction, body.rolling, body.rolling])
        shapes.append(Shape(name, body.name, not fixed, False, frictions))
    return shapes


def _add_part(spec: Any, body: Any, name: str, part: FloatArray, group: int) -> None:
    """A convex part; a box where it is one, since boxes have contacts at every corner."""
    common = {"name": name, "group": group, "contype": 0, "conaffinity": 0, "mass": 0.0}
    if (box := _as_box(part)) is not None:
        pose, half = box
        position, quaternion = _position_and_quaternion(pose)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=position, quat=quaternion, **common)
        return
    mesh = spec.add_mesh(name=name, uservert=np.asarray(part).ravel())
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, **common)


def _as_box(part: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Pose (4, 4) and half extents (3,) of a part that is a box; None where it is none."""
    if len(part) != 8:
        return None
    middle = part.mean(axis=0)
    corners = part - middle
    edges = corners[1:] - corners[0]
    edges = edges[np.argsort(np.linalg.norm(edges, axis=1))]
    for i, j, k in combinations(range(len(edges)), 3):
        axes = edges[[i, j, k]]
        lengths = np.linalg.norm(axes, axis=1)
        unit = axes / lengths[:, None]
        if np.abs(unit @ unit.T - np.eye(3)).max() > 1e-6:
            continue
        if np.linalg.det(unit) < 0.0:
            unit[2] *= -1.0
        local = corners @ unit.T
        if np.abs(np.abs(local) - lengths / 2.0).max() > SQUARE:
            continue
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = unit.T, middle
        return pose, lengths / 2.0
    return None


def _add_arm(spec: Any, arm: Arm, pose_base_to_world: FloatArray) -> list[Shape]:
    """The arm's links, with the convex parts that its motions are checked with."""
    jaw = arm.jaw
    pads = jaw.links if jaw is not None else ()
    driven = dict(zip(arm.joints, range(len(arm.joints)), strict=True))
    hand = tuple(arm.hand_values(arm.open_hand))
    added: dict[str, Any] = {}
    shapes: list[Shape] = []
    for link, frame in zip(arm.links, arm.frame_of_link, strict=True):
        joint = arm.model.joints.get(link)
        parent = spec.worldbody if joint is None else added[joint.parent]
        pose = pose_base_to_world if joint is None else joint.pose_child_to_parent
        position, quaternion = _position_and_quaternion(pose)
        body = parent.add_body(name=f"robot {link}", pos=position, quat=quaternion)
        added[link] = body
        if joint is not None and (joint.name in driven or joint.name in hand):
            sliding = joint.kind == "prismatic"
            body.add_joint(
                name=f"robot {joint.name}", axis=joint.axis,
                type=mujoco.mjtJoint.mjJNT_SLIDE if sliding else mujoco.mjtJoint.mjJNT_HINGE,
                armature=ROTOR if joint.name in driven else _finger_rotor(arm, joint.name),
            )  # fmt: skip
        beyond = frame == len(arm.joints) and joint is not None and joint.name not in driven
        body.gravcomp = 1.0 if beyond and hand else 0.0
        if (inertial := arm.model.links[link].inertial) is not None:
            body.explicitinertial, body.mass = True, inertial.mass
            body.ipos, _ = _position_and_quaternion(inertial.pose_inertial_to_link)
            axes = inertial.pose_inertial_to_link[:3, :3]
            turned = axes @ _possible(inertial.tensor) @ axes.T
            body.fullinertia = [turned[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        pad = link in pads
        for k, part in enumerate(arm.model.links[link].parts):
            name = f"robot {link} {k}"
            _add_part(spec, body, name, part, TOUCHING)
            grip = jaw.friction if jaw is not None and pad else LINK_FRICTION
            give = jaw.give if jaw is not None and pad else 0.0
            shapes.append(Shape(name, link, frame > 0, True, np.array([grip, give, 0.0])))
    if jaw is not None:
        _couple(spec, jaw.joints, jaw.joint_values)
    for name in (*driven, *hand):
        motor = spec.add_actuator(name=f"robot {name}", target=f"robot {name}")
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE  # no limit: a force cut off is not implicit, and shakes
    return shapes


def _finger_rotor(arm: Arm, joint: str) -> float:
    """Inertia of a finger's drive, or a cup's, as its joint feels it."""
    jaw = arm.jaw
    return FINGER_ROTOR * (jaw.lever(joint) ** 2 if jaw is not None and joint in jaw.joints else 1.0)


def _couple(spec: Any, joints: Sequence[str], values: FloatArray) -> None:
    """Hold the other joints of a jaw to the first, by the quartic through its strokes."""
    for k, name in enumerate(joints[1:], start=1):
        degree = min(4, len(values) - 1)
        fit = np.polynomial.polynomial.polyfit(values[:, 0], values[:, k], degree)
        tied = spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT, name1=f"robot {name}", name2=f"robot {joints[0]}",
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
        )  # fmt: skip
        tied.data[:] = 0.0
        tied.data[: degree + 1] = fit


def _possible(tensor: FloatArray) -> FloatArray:
    """The inertia tensor, made one that a rigid body can have: URDFs often state others."""
    moments, axes = np.linalg.eigh(tensor)
    moments = np.maximum(moments, 1e-6)
    moments[2] = min(moments[2], moments[0] + moments[1])
    return axes @ np.diag(moments) @ axes.T


def _position_and_quaternion(pose: FloatArray) -> tuple[list[float], list[float]]:
    """Position and quaternion, w x y z, of a (4, 4) pose."""
    position, (x, y, z, w) = position_and_quaternion(pose)
    return position, [w, x, y, z]
