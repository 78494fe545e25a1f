"""The PyBullet world: a table, bodies made of convex parts, and what touches what."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import numpy as np

from topple.robots.collision.rounding import Core, cores
from topple.robots.engine import pybullet
from topple.robots.poses import inverse, pose_from, position_and_quaternion
from topple.robots.scratch import Scratch
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.bodies import Body
from topple.robots.world.tolerances import TABLE_FRICTION, THICKNESS
from topple.topology.arrays import FloatArray
from topple.topology.errors import InvalidInput, UnknownObject


@dataclass(frozen=True)
class Physics:
    """How the world behaves.

    Attributes:
        gravity: In [m/s^2], down along z.
        time_step: In [s].
        iterations: Of the contact solver.
        damping: Share of linear and angular speed lost per second: air, and contacts that are soft.
    """

    gravity: float = 9.81
    time_step: float = TOLERANCES.time_step
    iterations: int = TOLERANCES.solver_iterations
    damping: float = 0.04


@dataclass(frozen=True, eq=False)
class Contact:
    """Two bodies touching at a point.

    Attributes:
        a: Name of one.
        b: Name of the other.
        point: (3,) on b in the world in [m].
        normal: (3,) unit, from b towards a.
        force: Normal force in [N].
        distance: Gap in [m], negative where they overlap.
    """

    a: str
    b: str
    point: FloatArray
    normal: FloatArray
    force: float
    distance: float


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


class World:
    """A PyBullet simulation of its own, to be used with `with`; z is up.

    Attributes:
        physics: Time step, gravity, solver.
        client: PyBullet's number of the simulation; to be given to every call of PyBullet.
        ids: PyBullet's number of every named body.
        robots: PyBullet's numbers of the robots.
        time: Simulated time in [s].
    """

    def __init__(self, physics: Physics | None = None) -> None:
        self.physics = physics or Physics()
        self.client: int = pybullet.connect(pybullet.DIRECT)
        self.ids: dict[str, int] = {}
        self.robots: set[int] = set()
        self.time = 0.0
        self._bodies: dict[str, Body] = {}
        self._inertial: dict[str, FloatArray] = {}  # pose_inertial_to_body
        self._fixed: set[str] = set()
        self._names: dict[int, str] = {}
        self._files = Scratch()
        self._written = 0
        pybullet.setGravity(0, 0, -self.physics.gravity, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self.physics.time_step,
            deterministicOverlappingPairs=1,
            numSolverIterations=self.physics.iterations,
            solverResidualThreshold=TOLERANCES.solver_residual,
            physicsClientId=self.client,
        )

    def __enter__(self) -> "World":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the simulation and remove its files; more than once does no harm."""
        if self.client >= 0:
            pybullet.disconnect(physicsClientId=self.client)
            self.client = -1
            self._files.close()

    @property
    def time_step(self) -> float:
        """Of the simulation in [s]."""
        return self.physics.time_step

    @property
    def names(self) -> tuple[str, ...]:
        """Of everything but robots, in the order it was added."""
        return tuple(self.ids)

    @property
    def fixed(self) -> frozenset[str]:
        """Names of what never moves."""
        return frozenset(self._fixed)

    @property
    def movable(self) -> tuple[str, ...]:
        """Names of what can move, in the order it was added."""
        return tuple(name for name in self.ids if name not in self._fixed)

    def add(self, body: Body, pose_body_to_world: FloatArray | None = None, *, fixed: bool = False) -> None:
        """Put a body into the world.

        Args:
            body: What to add; its name must be new.
            pose_body_to_world: (4, 4); None: the identity.
            fixed: Never moves, as a table.

        Raises:
            InvalidInput: If the name is taken.
        """
        if body.name in self.ids:
            raise InvalidInput(f"two bodies are called {body.name!r}: give each its own name")
        moments, pose_inertial_to_body = principal_axes(body)
        pose = (np.eye(4) if pose_body_to_world is None else pose_body_to_world) @ pose_inertial_to_body
        core = cores(body.parts)
        collision, visual = self._shapes(core, body, pose_inertial_to_body)
        number: int = pybullet.createMultiBody(
            0.0 if fixed else body.mass, collision, visual, *position_and_quaternion(pose),
            useMaximalCoordinates=True, physicsClientId=self.client,
        )  # fmt: skip
        self.ids[body.name], self._names[number] = number, body.name
        self._bodies[body.name], self._inertial[body.name] = body, pose_inertial_to_body
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

    def add_table(
        self,
        name: str = "table",
        *,
        height: float = 0.0,
        size: tuple[float, float] = (1.2, 1.2),
        centre: tuple[float, float] = (0.0, 0.0),
        friction: float = TABLE_FRICTION,
        more: Sequence[FloatArray] = (),
    ) -> None:
        """Put a fixed table top into the world, and a floor far below that stops what falls off it.

        Args:
            name: Its name; the floor has none.
            height: Of its surface in [m].
            size: Along x and y in [m].
            centre: (x, y) in [m].
            friction: Coulomb coefficient.
            more: (V, 3) corners of further convex parts of it in the world [m]: a shelf's boards and walls.
        """
        corner = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-1.0, 0.0)])
        top = Body.of(
            name, [corner * [size[0], size[1], THICKNESS], *(part - [*centre, height] for part in more)],
            friction=friction, rolling=0.0, color=(0.72, 0.62, 0.5, 1.0), kind="table",
        )  # fmt: skip
        pose = np.eye(4)
        pose[:3, 3] = [*centre, height]
        self.add(top, pose, fixed=True)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self.client)
        pybullet.createMultiBody(
            0.0, plane, basePosition=[0, 0, height - TOLERANCES.floor_drop], physicsClientId=self.client
        )

    def register_robot(self, number: int) -> None:
        """Note that PyBullet's body `number` is a robot: no object, and background to the cameras."""
        self.robots.add(number)

    def remove(self, name: str) -> None:
        """Take a body out of the world."""
        number = self._number(name)
        pybullet.removeBody(number, physicsClientId=self.client)
        del self.ids[name], self._names[number], self._bodies[name], self._inertial[name]
        self._fixed.discard(name)

    def name_of(self, number: int) -> str | None:
        """The name of PyBullet's body `number`; None for robots and the unknown."""
        return self._names.get(number)

    def body(self, name: str) -> Body:
        """The body called `name`."""
        self._number(name)
        return self._bodies[name]

    def pose(self, name: str) -> FloatArray:
        """(4, 4) pose_body_to_world of a body."""
        found: Any = pybullet.getBasePositionAndOrientation(self._number(name), physicsClientId=self.client)
        return pose_from(*found) @ inverse(self._inertial[name])

    def poses(self) -> dict[str, FloatArray]:
        """(4, 4) pose_body_to_world of everything that can move, by name."""
        return {name: self.pose(name) for name in self.movable}

    def parts(self, name: str) -> tuple[FloatArray, ...]:
        """Vertices (V, 3) of the convex parts of a body where it is now, in the world in [m]."""
        pose = self.pose(name)
        return tuple(part @ pose[:3, :3].T + pose[:3, 3] for part in self._bodies[name].parts)

    def place(self, name: str, pose_body_to_world: FloatArray) -> None:
        """Set a body down somewhere at rest: for building scenes, not for acting in them."""
        number = self._number(name)
        pose = pose_body_to_world @ self._inertial[name]
        pybullet.resetBasePositionAndOrientation(
            number, *position_and_quaternion(pose), physicsClientId=self.client
        )
        pybullet.resetBaseVelocity(number, [0, 0, 0], [0, 0, 0], physicsClientId=self.client)

    def step(self, count: int = 1) -> None:
        """Advance the simulation by `count` time steps."""
        for _ in range(count):
            pybullet.stepSimulation(physicsClientId=self.client)
        self.time += count * self.time_step

    def settle(self, seconds: float = 3.0) -> bool:
        """Step until everything is at rest.

        Args:
            seconds: Longest simulated time to wait.

        Returns:
            Whether everything came to rest in time.
        """
        pause = 6
        needed, calm = TOLERANCES.still_for / self.time_step, 0
        for _ in range(max(1, round(seconds / (pause * self.time_step)))):
            self.step(pause)
            calm = calm + pause if self.at_rest() else 0
            if calm >= needed:
                return True
        return False

    def at_rest(self) -> bool:
        """Whether nothing moves at this instant."""
        for name in self.movable:
            velocity: Any = pybullet.getBaseVelocity(self.ids[name], physicsClientId=self.client)
            speed, turn = np.linalg.norm(velocity, axis=1)
            if speed > TOLERANCES.still_speed or turn > TOLERANCES.still_turn:
                return False
        return True

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

    def snapshot(self) -> Snapshot:
        """Keep the state of the simulation, for `restore`."""
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
        pybullet.restoreState(snapshot.number, physicsClientId=self.client)
        self.time = snapshot.time

    def _number(self, name: str) -> int:
        if name not in self.ids:
            raise UnknownObject(name, self.ids)
        return self.ids[name]

    def _shapes(self, core: Core, body: Body, pose_inertial_to_body: FloatArray) -> tuple[int, int]:
        """Numbers of the collision and the visual shape, in the frame PyBullet moves."""
        pose = inverse(pose_inertial_to_body)
        parts = [part @ pose[:3, :3].T + pose[:3, 3] for part in core.parts]
        fans = [np.array([[0, k, k + 1] for k in range(1, len(part) - 1)]) for part in parts]
        seen = body.mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        collision: int = pybullet.createCollisionShape(
            pybullet.GEOM_MESH, fileName=self._obj(parts, fans), physicsClientId=self.client
        )
        visual: int = pybullet.createVisualShape(
            pybullet.GEOM_MESH, fileName=self._obj([seen], [body.mesh.faces]), rgbaColor=body.color,
            specularColor=[0.1, 0.1, 0.1], physicsClientId=self.client,
        )  # fmt: skip
        _set_margin(collision, core.margin, self.client)
        return collision, visual

    def _obj(self, parts: list[FloatArray], faces: list[Any]) -> str:
        """Write a Wavefront file, one object a part: the one way PyBullet takes many hulls as one shape."""
        path = self._files.path / f"{self._written}.obj"
        self._written += 1
        lines: list[str] = []
        first = 1
        for k, (part, triangles) in enumerate(zip(parts, faces, strict=True)):
            lines.append(f"o part{k}")
            lines += [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in part]
            lines += [f"f {a} {b} {c}" for a, b, c in triangles + first]
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


def principal_axes(body: Body) -> tuple[FloatArray, FloatArray]:
    """Principal moments of inertia and the frame they hold in.

    Args:
        body: Any body.

    Returns:
        Moments (3,) in [kg m^2], and (4, 4) pose_inertial_to_body at the centre of mass; parallel to
        the body's frame where that is principal within one percent, so that symmetric bodies keep their axes.
    """
    pose = np.eye(4)
    pose[:3, 3] = body.centre_of_mass
    moments = np.diag(body.inertia).copy()
    if np.abs(body.inertia - np.diag(moments)).max() > 0.01 * moments.min():
        moments, axes = np.linalg.eigh(body.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        pose[:3, :3] = axes
    return moments, pose
