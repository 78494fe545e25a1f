"""The PyBullet world: a table, bodies made of convex parts, and what touches what."""

import ctypes
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.robots.collision.rounding import Core, cores
from topple.robots.engine import pybullet
from topple.robots.poses import inverse, pose_from, position_and_quaternion
from topple.robots.scratch import Scratch
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.bodies import Body
from topple.robots.world.bullet_shapes import shown_in
from topple.robots.world.bullet_sleep import Sleep
from topple.robots.world.physical_world import (
    Constraint,
    Contact,
    Drawn,
    PhysicalWorld,
    Physics,
    principal_axes,
)
from topple.robots.world.rendering import Shown
from topple.robots.world.tolerances import CLAMPING, CONSTRAINT_ERP
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points


@dataclass(frozen=True)
class Snapshot:
    """A kept state of a world.

    Attributes:
        number: PyBullet's number of it.
        time: Simulated time in [s].
        names: What was in the world.
    """

    number: int
    time: float
    names: frozenset[str]


@checked_arguments
class World(PhysicalWorld):
    """A PyBullet simulation of its own, to be used with `with`; z is up.

    Attributes:
        client: PyBullet's number of the simulation; to be given to every call of PyBullet.
        sleep: What rests and costs nothing; to be woken before something is done to bodies from outside.
        robots: PyBullet's number of each robot -> what draws it; None: the shapes that PyBullet has of it.

    Examples:
        >>> with World() as world:
        ...     world.names, world.time
        ((), 0.0)
    """

    engine = "bullet"

    def __init__(self, physics: Physics | None = None) -> None:
        super().__init__(physics)
        self.client: int = pybullet.connect(pybullet.DIRECT)
        self.robots: dict[int, Drawn | None] = {}
        self._inertial: dict[str, FloatArray] = {}  # pose_inertial_to_body
        self._body_to_inertial: dict[str, FloatArray] = {}
        self._names: dict[int, str] = {}
        self.sleep = Sleep(self, self.client)
        self._files = Scratch()
        self._written = 0
        pybullet.setGravity(0, 0, -self.physics.gravity, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self.physics.time_step,
            deterministicOverlappingPairs=1,
            numSolverIterations=self.physics.iterations,
            solverResidualThreshold=TOLERANCES.solver_residual,
            enableFileCaching=0,  # it would keep the file of every body there ever was
            physicsClientId=self.client,
        )

    def close(self) -> None:
        """End the simulation and remove its files; more than once does no harm."""
        if self.client >= 0:
            pybullet.disconnect(physicsClientId=self.client)
            self.client = -1
            self._files.close()
            _give_back()

    def add(self, body: Body, pose_body_to_world: FloatArray | None = None, *, fixed: bool = False) -> None:
        """Put a body into the world; see `PhysicalWorld.add`."""
        self.sleep.wake()
        if body.name in self.ids:
            raise InvalidInput(f"two bodies are called {body.name!r}: give each its own name")
        moments, pose_inertial_to_body = principal_axes(body)
        pose = (np.eye(4) if pose_body_to_world is None else pose_body_to_world) @ pose_inertial_to_body
        core = cores(body.parts)
        shape = self._shape(core, pose_inertial_to_body)
        number: int = pybullet.createMultiBody(
            0.0 if fixed else body.mass, shape, -1, *position_and_quaternion(pose),
            useMaximalCoordinates=True, physicsClientId=self.client,
        )  # fmt: skip
        self.ids[body.name], self._names[number] = number, body.name
        self._bodies[body.name], self._inertial[body.name] = body, pose_inertial_to_body
        self._body_to_inertial[body.name] = inverse(pose_inertial_to_body)
        if fixed:
            self._fixed.add(body.name)
        else:
            pybullet.changeDynamics(
                number, -1, mass=body.mass, localInertiaDiagonal=moments.tolist(), physicsClientId=self.client
            )
        pybullet.changeDynamics(
            number, -1, lateralFriction=body.friction, rollingFriction=body.rolling,
            spinningFriction=body.rolling, restitution=0.0,
            linearDamping=self.physics.damping, angularDamping=self.physics.damping,
            physicsClientId=self.client,
        )  # fmt: skip

    def __enter__(self) -> "World":
        return self

    def _add_floor(self, height: float) -> None:
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self.client)
        pybullet.createMultiBody(0.0, plane, basePosition=[0, 0, height], physicsClientId=self.client)

    def register_robot(self, number: int, drawn: Drawn | None = None) -> None:
        """Note that PyBullet's body `number` is a robot: no object, and background to the cameras."""
        self.robots[number] = drawn
        if drawn is not None:
            self.arms.append(drawn)

    def remove(self, name: str) -> None:
        """Take a body out of the world."""
        self.sleep.wake()
        number = self._number(name)
        pybullet.removeBody(number, physicsClientId=self.client)
        del self.ids[name], self._names[number], self._bodies[name], self._inertial[name]
        del self._body_to_inertial[name]
        self._fixed.discard(name)

    def name_of(self, number: int) -> str | None:
        """The name of PyBullet's body `number`; None for robots and the unknown."""
        return self._names.get(number)

    def pose(self, name: str) -> FloatArray:
        """(4, 4) pose_body_to_world of a body."""
        found: Any = pybullet.getBasePositionAndOrientation(self._number(name), physicsClientId=self.client)
        return pose_from(*found) @ self._body_to_inertial[name]

    def place(self, name: str, pose_body_to_world: FloatArray, rising: float = 0.0) -> None:
        """Set a body somewhere; see `PhysicalWorld.place`."""
        self.sleep.wake()
        number = self._number(name)
        pose = pose_body_to_world @ self._inertial[name]
        pybullet.resetBasePositionAndOrientation(
            number, *position_and_quaternion(pose), physicsClientId=self.client
        )
        pybullet.resetBaseVelocity(number, [0, 0, rising], [0, 0, 0], physicsClientId=self.client)

    def clamp(self, name: str) -> Callable[[], None]:
        """Keep a body where it is, by a constraint that holds up to `CLAMPING`; see `PhysicalWorld.clamp`.

        The constraint yields to a weight until what it makes up for in a step is what that adds: it is as
        much too high before.
        """
        number, client = self._number(name), self.client
        (x, y, z), turned = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)
        sag = self.physics.gravity * self.time_step**2 / CONSTRAINT_ERP
        clamp: int = pybullet.createMultiBody(  # without a shape: nothing meets it
            0.0, basePosition=[x, y, z + sag], baseOrientation=turned, physicsClientId=client
        )
        grip: int = pybullet.createConstraint(
            clamp, -1, number, -1, pybullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], [0, 0, 0],
            physicsClientId=client,
        )  # fmt: skip
        pybullet.changeConstraint(grip, maxForce=CLAMPING, physicsClientId=client)

        def let_go() -> None:
            self.sleep.wake()
            pybullet.removeConstraint(grip, physicsClientId=client)
            pybullet.removeBody(clamp, physicsClientId=client)

        return let_go

    def step(self, count: int = 1) -> None:
        """Advance the simulation by `count` time steps."""
        self.sleep.wake()
        for _ in range(count):
            self.advance()

    def advance(self) -> None:
        """Take one time step in which what sleeps goes on sleeping."""
        pybullet.stepSimulation(physicsClientId=self.client)
        self.time += self.time_step

    def speeds(self, name: str) -> tuple[float, float]:
        """Speed in [m/s] and turning speed in [rad/s] of a body."""
        velocity: Any = pybullet.getBaseVelocity(self.ids[name], physicsClientId=self.client)
        speed, turn = np.linalg.norm(velocity, axis=1)
        return float(speed), float(turn)

    def shown(self) -> Iterator[Shown]:
        """All that cameras see, where it is now; what others put into the simulation as well."""
        yield from super().shown()
        count: int = pybullet.getNumBodies(physicsClientId=self.client)
        for k in range(count):
            number = pybullet.getBodyUniqueId(k, physicsClientId=self.client)
            if number not in self._names and self.robots.get(number) is None:
                yield from shown_in(self.client, number)

    def contacts(self) -> list[Contact]:
        """Everything that touched in the last step, robots and the floor left out."""
        found: list[Contact] = []
        points: Any = pybullet.getContactPoints(physicsClientId=self.client)
        for point in points or ():
            a, b = self._names.get(point[1]), self._names.get(point[2])
            if a is not None and b is not None and point[8] <= TOLERANCES.contact:
                found.append(
                    Contact(a, b, np.array(point[6]), np.array(point[7]), float(point[9]), float(point[8]))
                )
        return found

    def constraints(self) -> tuple[Constraint, ...]:
        """Everything that ties bodies together."""
        count: int = pybullet.getNumConstraints(physicsClientId=self.client)
        found: list[Constraint] = []
        for k in range(count):
            number = pybullet.getConstraintUniqueId(k, physicsClientId=self.client)
            info: Any = pybullet.getConstraintInfo(number, physicsClientId=self.client)
            parent, child = (
                "robot" if body in self.robots else self._names.get(body, "world")
                for body in (info[0], info[2])
            )
            kind = "gear" if info[4] == pybullet.JOINT_GEAR else "fixed"
            found.append(Constraint(kind, parent, child, float(info[10])))
        return tuple(found)

    def snapshot(self) -> Snapshot:
        """Keep the state of the simulation, for `restore`."""
        self.sleep.wake()
        number = int(pybullet.saveState(physicsClientId=self.client))
        return Snapshot(number, self.time, frozenset(self.ids))

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a kept state.

        Raises:
            InvalidInput: If bodies were added or removed since.
        """
        if snapshot.names != frozenset(self.ids):
            changed = sorted(snapshot.names ^ frozenset(self.ids))
            raise InvalidInput(f"{', '.join(changed)} came or went since the snapshot: take a new one")
        self.sleep.wake()
        pybullet.restoreState(snapshot.number, physicsClientId=self.client)
        self.time = snapshot.time

    def _shape(self, core: Core, pose_inertial_to_body: FloatArray) -> int:
        """Number of the collision shape, in the frame PyBullet moves."""
        pose = inverse(pose_inertial_to_body)
        parts = [move_points(part, pose) for part in core.parts]
        fans = [np.array([[0, k, k + 1] for k in range(1, len(part) - 1)]) for part in parts]
        shape: int = pybullet.createCollisionShape(
            pybullet.GEOM_MESH, fileName=self._obj(parts, fans), physicsClientId=self.client
        )
        _set_margin(shape, core.margin, self.client)
        return shape

    def _obj(self, parts: list[FloatArray], faces: list[Any]) -> str:
        """Write a Wavefront file, one object a part: the one way PyBullet takes many hulls as one shape."""
        path = self._files.path / f"{self._written}.obj"
        self._written += 1
        lines: list[str] = []
        first = 1
        for k, (part, triangles) in enumerate(zip(parts, faces, strict=True)):
            lines.append(f"o part{k}")
            lines += [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in part.tolist()]
            lines += [f"f {a} {b} {c}" for a, b, c in (triangles + first).tolist()]
            first += len(part)
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        return str(path)


def _set_margin(shape: int, margin: float, client: int) -> None:
    """Set the collision margin of every part of a shape.

    PyBullet passes a margin on to a shape's parts only for its slower kind of body, so one is made for a
    moment; the parts are shared by all bodies of the shape.
    """
    body: int = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
    pybullet.changeDynamics(body, -1, collisionMargin=margin, physicsClientId=client)
    pybullet.removeBody(body, physicsClientId=client)


def _give_back() -> None:
    """Return freed memory to the system, where the C library can: it holds what worlds have scattered."""
    trim: Any = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


@checked_arguments
def in_bullet(world: PhysicalWorld) -> World:
    """The same world, known to be PyBullet's.

    Args:
        world: A world.

    Raises:
        InvalidInput: It is played on another engine.
    """
    if not isinstance(world, World):
        raise InvalidInput(f"this needs a world on PyBullet, found one on {world.engine}")
    return world
