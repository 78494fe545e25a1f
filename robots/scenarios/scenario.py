"""Scenario: a settled scene with cameras, a robot's place and a task; what all built-in ones share."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.engines import new_world
from topple.robots.poses import angle_between
from topple.robots.scenarios.tolerances import ATTEMPTS, CREEP, OVERLAP, REACHED, SLID, TURN, WATCHED
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError

TABLE = (1.4, 1.2)  # [m] the robot stands on it too
TABLE_CENTRE = (-0.05, 0.0)
BASE = (
    -0.55,
    0.0,
    0.0,
)  # [m] of the robot, facing +x: what lies about the origin is well within a Panda's reach
CAMERAS = 3
DISTANCE = 0.62  # [m] of the cameras from what they look at, along the table
HEIGHT = 0.60  # [m] of the cameras above the table


@dataclass(frozen=True, eq=False)
class Scenario:
    """A task in a world, to be used with `with`: leaving it ends the simulation.

    Attributes:
        name: Name of the scenario.
        seed: The seed it was made from.
        world: Settled, with a table at height 0 and everything about the origin.
        goal: The task in the language of the relations.
        targets: The objects it is about.
        cameras: Around and above; the first one alone sees most.
        fixed: Names of what never moves.
        robot: Name of the robot that can do it.
        pose_base_to_world: (4, 4) where that robot stands.
        up: (3,) against gravity.
        finished: Where the task is to copy an arrangement, a world in which the same bodies lie so.
        pose_second_to_world: (4, 4) where a second robot of the same kind stands; None where one can do it.
    """

    name: str
    seed: int
    world: PhysicalWorld
    goal: str
    targets: tuple[str, ...]
    cameras: tuple[Camera, ...]
    fixed: tuple[str, ...]
    robot: str
    pose_base_to_world: FloatArray
    up: FloatArray
    finished: PhysicalWorld | None = None
    pose_second_to_world: FloatArray | None = None

    def __enter__(self) -> "Scenario":
        return self

    def __exit__(self, *_: object) -> None:
        self.world.close()
        if self.finished is not None:
            self.finished.close()


class Unlucky(ToppleError):
    """A layout did not settle as it should: another one is tried."""


def settled(
    name: str,
    seed: int,
    layout: Callable[[PhysicalWorld, np.random.Generator], tuple[str, tuple[str, ...]]],
    *,
    robot: str = "panda-suction",
) -> Scenario:
    """Make layouts from one seed until one settles as it should.

    Args:
        name: Name of the scenario.
        seed: Any number; the same one gives the same scene.
        layout: Fills a world that has a table, lets it settle and returns goal and targets; raises Unlucky
            where something fell or lies elsewhere than it should.
        robot: Name of the robot that can do it.

    Returns:
        The scenario.

    Raises:
        ToppleError: If no layout works out.
    """
    return _made(name, seed, 1, lambda worlds, rng: layout(worlds[0], rng), robot)


def to_copy(
    name: str,
    seed: int,
    layout: Callable[[PhysicalWorld, PhysicalWorld, np.random.Generator], tuple[str, tuple[str, ...]]],
    *,
    robot: str = "panda",
) -> Scenario:
    """Make layouts of a start and of the arrangement it shall become, until both settle as they should.

    Args:
        name: Name of the scenario.
        seed: Any number; the same one gives the same scene.
        layout: Fills two worlds that have a table with the same bodies, the start first, lets both settle and
            returns goal and targets; raises Unlucky where something fell or lies elsewhere than it should.
        robot: Name of the robot that can do it.

    Returns:
        The scenario, whose `finished` is the arrangement.

    Raises:
        ToppleError: If no layout works out.
    """
    return _made(name, seed, 2, lambda worlds, rng: layout(worlds[0], worlds[1], rng), robot)


def _made(
    name: str,
    seed: int,
    count: int,
    layout: Callable[[Sequence[PhysicalWorld], np.random.Generator], tuple[str, tuple[str, ...]]],
    robot: str,
) -> Scenario:
    """Lay out some worlds, the start and what it shall become, until all of them settle as they should."""
    rng = np.random.default_rng([seed, *name.encode()])
    reason = ""
    for _ in range(ATTEMPTS):
        with ExitStack() as stack:
            worlds = [stack.enter_context(new_world()) for _ in range(count)]
            try:
                for world in worlds:
                    world.add_table(size=TABLE, centre=TABLE_CENTRE)
                goal, targets = layout(worlds, rng)
                for world in worlds:
                    _watch(world)
            except Unlucky as error:
                reason = str(error)
                continue
            stack.pop_all()
        world, finished = worlds[0], worlds[1] if count > 1 else None
        fixed = tuple(name for name in world.names if name in world.fixed)
        base = np.eye(4)
        base[:3, 3] = BASE
        cameras = around((0.0, 0.0, 0.03))
        up = np.array([0.0, 0.0, 1.0])
        return Scenario(name, seed, world, goal, targets, cameras, fixed, robot, base, up, finished)
    raise ToppleError(f"scenario {name!r} found no layout for seed {seed} in {ATTEMPTS} attempts: {reason}")


@checked_arguments
def around(target: tuple[float, float, float]) -> tuple[Camera, ...]:
    """Three cameras around a place (3,) [m], looking down at it, the first one opposite the robot.

    Examples:
        >>> len(around((0, 0, 0)))
        3
    """
    angles = np.arange(CAMERAS) * (2 * np.pi / CAMERAS)
    return tuple(
        Camera.looking_at(
            (target[0] + DISTANCE * np.cos(a), target[1] + DISTANCE * np.sin(a), HEIGHT), target
        )
        for a in angles.tolist()
    )


def pose_at(x: float, y: float, z: float, turn: Rotation | None = None) -> FloatArray:
    """(4, 4) pose at a place in [m], turned."""
    pose = np.eye(4)
    pose[:3, 3] = [x, y, z]
    if turn is not None:
        pose[:3, :3] = turn.as_matrix()
    return pose


def settle(world: PhysicalWorld, seconds: float = 4.0) -> None:
    """Let everything come to rest on the table.

    Raises:
        Unlucky: If something does not rest, or fell off.
    """
    if not world.settle(seconds):
        raise Unlucky("something does not come to rest")
    for name, pose in world.poses().items():
        if pose[2, 3] < -0.01 or (np.abs(pose[:2, 3]) > REACHED).any():
            raise Unlucky(f"{name} fell or rolled away")


def _watch(world: PhysicalWorld) -> None:
    """See that nothing creeps, or falls by itself: it would be blamed on the robot.

    Raises:
        Unlucky: If something does.
    """
    before = world.poses()
    world.step(round(WATCHED / world.time_step))
    for name, pose in world.poses().items():
        moved = np.linalg.norm((pose - before[name])[:3, 3])
        if moved > CREEP or angle_between(pose, before[name]) > TURN:
            raise Unlucky(f"{name} creeps")


def overlap(world: PhysicalWorld) -> float:
    """How deep two bodies are in each other right now in [m]; 0 if none are."""
    world.step()
    return max((-contact.distance for contact in world.contacts()), default=0.0)


def contacts(world: PhysicalWorld) -> set[frozenset[str]]:
    """Pairs of names that touch."""
    return {frozenset((contact.a, contact.b)) for contact in world.contacts()}


def lay(world: PhysicalWorld, places: Mapping[Body, FloatArray]) -> None:
    """Put bodies where they shall lie, and let them settle there.

    Args:
        world: Where to.
        places: (4, 4) pose of each.

    Raises:
        Unlucky: If two are in the same place, or one does not stay where it was put.
    """
    for body, pose in places.items():
        world.add(body, pose)
    if overlap(world) > OVERLAP:
        raise Unlucky("two things would be in the same place")
    settle(world)
    for body, pose in places.items():
        if np.linalg.norm((world.pose(body.name) - pose)[:2, 3]) > SLID:
            raise Unlucky(f"{body.name} does not stay where it was put")


def drop(
    world: PhysicalWorld, body: Body, x: float, y: float, turn: Rotation, clearance: float = 0.004
) -> None:
    """Let a body go just above what lies under it.

    Args:
        world: Where to.
        body: What to drop.
        x: Place of its centre in [m].
        y: Place of its centre in [m].
        turn: How it is held.
        clearance: Gap below it in [m].
    """
    corners = np.concatenate(body.parts) @ turn.as_matrix().T
    reach = float(np.linalg.norm(corners[:, :2], axis=1).max())
    below = 0.0
    for name in world.movable:
        points = np.concatenate(world.parts(name))
        if np.linalg.norm(points[:, :2] - [x, y], axis=1).min() < reach + 0.01:
            below = max(below, float(points[:, 2].max()))
    world.add(body, pose_at(x, y, below + clearance - float(corners[:, 2].min()), turn))
