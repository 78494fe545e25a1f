"""A world that is played: what every engine offers of it, and what is the same in all of them."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol
from weakref import WeakKeyDictionary

import numpy as np

from topple.robots.tolerances import TOLERANCES
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera, Rendered
from topple.robots.world.rendering import NOBODY, Shown, Surface, draw
from topple.robots.world.tolerances import FLOOR, FLOOR_COLOUR, TABLE_FRICTION, THICKNESS
from topple.topology.base.arrays import FloatArray, round_off
from topple.topology.base.errors import UnknownObject
from topple.topology.geometry.rigid import move_points


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
class Constraint:
    """What ties two bodies together but their contacts.

    Attributes:
        kind: "gear" for fingers that move together, "fixed" for what is held as it is.
        parent: Name of one body; "robot" for an arm, "world" for what stands still.
        child: Name of the other.
        max_force: What it holds at most in [N]; infinite where the engine sets no limit.
    """

    kind: str
    parent: str
    child: str
    max_force: float


class Drawn(Protocol):
    """What cameras see beside bodies, such as an arm."""

    def shown(self) -> Iterator[Shown]:
        """Its surfaces where they are now."""
        ...


class PhysicalWorld(ABC):
    """A simulation of its own, to be used with `with`; z is up.

    Attributes:
        engine: Name of what plays it, one of `topple.robots.engines.ENGINES`.
        physics: Time step, gravity, solver.
        ids: The engine's number of every named body.
        time: Simulated time in [s].
        arms: What cameras see beside the bodies.
    """

    engine: ClassVar[str]

    def __init__(self, physics: Physics | None = None) -> None:
        self.physics = physics or Physics()
        self.ids: dict[str, int] = {}
        self.time = 0.0
        self.arms: list[Drawn] = []
        self._bodies: dict[str, Body] = {}
        self._fixed: set[str] = set()
        self._floors: list[Surface] = []
        self._surfaces: WeakKeyDictionary[Body, Surface] = WeakKeyDictionary()

    def __enter__(self) -> "PhysicalWorld":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def close(self) -> None:
        """End the simulation; more than once does no harm."""

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

    @abstractmethod
    def add(self, body: Body, pose_body_to_world: FloatArray | None = None, *, fixed: bool = False) -> None:
        """Put a body into the world.

        Args:
            body: What to add; its name must be new.
            pose_body_to_world: (4, 4); None: the identity.
            fixed: Never moves, as a table.

        Raises:
            InvalidInput: If the name is taken.
        """

    @abstractmethod
    def remove(self, name: str) -> None:
        """Take a body out of the world."""

    def add_floor(self, height: float) -> None:
        """Put a level floor without a name into the world, at a height in [m]."""
        corners = np.array([[x, y, height] for x in (-FLOOR, FLOOR) for y in (-FLOOR, FLOOR)])
        self._floors.append(Surface.of(corners, np.array([[0, 2, 1], [1, 2, 3]]), FLOOR_COLOUR))
        self._add_floor(height)

    @abstractmethod
    def _add_floor(self, height: float) -> None:
        """Put a floor into the simulation."""

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
        self.add_floor(height - TOLERANCES.floor_drop)

    def body(self, name: str) -> Body:
        """The body called `name`."""
        self._number(name)
        return self._bodies[name]

    @abstractmethod
    def pose(self, name: str) -> FloatArray:
        """(4, 4) pose_body_to_world of a body."""

    def poses(self) -> dict[str, FloatArray]:
        """(4, 4) pose_body_to_world of everything that can move, by name."""
        return {name: self.pose(name) for name in self.movable}

    def parts(self, name: str) -> tuple[FloatArray, ...]:
        """Vertices (V, 3) of the convex parts of a body where it is now, in the world in [m]."""
        pose = self.pose(name)
        return tuple(move_points(part, pose) for part in self._bodies[name].parts)

    @abstractmethod
    def place(self, name: str, pose_body_to_world: FloatArray, rising: float = 0.0) -> None:
        """Set a body somewhere, at rest or rising at a speed [m/s]: for building scenes, not for acting."""

    @abstractmethod
    def clamp(self, name: str) -> Callable[[], None]:
        """Keep a body where it is until what this returns is called, which lets go of it."""

    @abstractmethod
    def step(self, count: int = 1) -> None:
        """Advance the simulation by `count` time steps."""

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

    def at_rest(self, names: Iterable[str] | None = None) -> bool:
        """Whether nothing moves at this instant, of what is named where something is."""
        for name in self.movable if names is None else names:
            speed, turn = self.speeds(name)
            if speed > TOLERANCES.still_speed or turn > TOLERANCES.still_turn:
                return False
        return True

    @abstractmethod
    def speeds(self, name: str) -> tuple[float, float]:
        """Speed in [m/s] and turning speed in [rad/s] of a body."""

    @abstractmethod
    def contacts(self) -> list[Contact]:
        """Everything that touched in the last step, robots and the floor left out."""

    @abstractmethod
    def constraints(self) -> tuple[Constraint, ...]:
        """Everything that ties bodies together."""

    def rendered(self, camera: Camera) -> Rendered:
        """Render the view of a camera without faults."""
        return draw(camera, self.shown())

    def shown(self) -> Iterator[Shown]:
        """All that cameras see, where it is now."""
        for name, body in self._bodies.items():
            if body not in self._surfaces:
                colour = [255 * share for share in body.color[:3]]
                self._surfaces[body] = Surface.of(body.mesh.vertices, body.mesh.faces, colour)
            yield self._surfaces[body], self.pose(name), self.ids[name]
        for floor in self._floors:
            yield floor, np.eye(4), NOBODY
        for arm in self.arms:
            yield from arm.shown()

    def _number(self, name: str) -> int:
        if name not in self.ids:
            raise UnknownObject(name, self.ids)
        return self.ids[name]


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
        pose[:3, :3] = round_off(axes)
    return round_off(moments, TOLERANCES.inertia_decimals), pose
