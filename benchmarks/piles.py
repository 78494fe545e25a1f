"""Seeded piles of household things, as truth to measure against: settled, seen, and lifted from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from topple.planner.simulate.lift import Move
from topple.planner.simulate.lifts import set_friction, take_away
from topple.planner.simulate.tolerances import FRICTIONS
from topple.robots import shapes
from topple.robots.engine import pybullet
from topple.robots.world.bodies import Body
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

NOISE = 0.001
"""Standard deviation of a depth camera's noise at arm's length [m]."""

SAMPLES = 2500
"""Points per cloud."""

Maker = Callable[[str, np.random.Generator], Body]


def _box(name: str, rng: np.random.Generator) -> Body:
    return shapes.box(name, tuple(rng.uniform(0.05, 0.13, 3)))


def _flat(name: str, rng: np.random.Generator) -> Body:
    return shapes.box(name, (rng.uniform(0.12, 0.22), rng.uniform(0.08, 0.16), rng.uniform(0.025, 0.05)))


def _can(name: str, rng: np.random.Generator) -> Body:
    return shapes.can(name, diameter=rng.uniform(0.05, 0.1), height=rng.uniform(0.06, 0.13))


def _ball(name: str, rng: np.random.Generator) -> Body:
    return shapes.ball(name, diameter=rng.uniform(0.04, 0.07))


def _lemon(name: str, rng: np.random.Generator) -> Body:
    size = rng.uniform(0.85, 1.1)
    return shapes.lemon(name, diameter=0.055 * size, length=0.075 * size)


def _bowl(name: str, rng: np.random.Generator) -> Body:
    return shapes.bowl(name, diameter=rng.uniform(0.13, 0.17), height=rng.uniform(0.05, 0.065))


def _plate(name: str, rng: np.random.Generator) -> Body:
    return shapes.plate(name, diameter=rng.uniform(0.2, 0.26))


def _mug(name: str, rng: np.random.Generator) -> Body:
    return shapes.mug(name, diameter=rng.uniform(0.075, 0.095), height=rng.uniform(0.08, 0.1))


def _spoon(name: str, rng: np.random.Generator) -> Body:
    return shapes.spoon(name, length=rng.uniform(0.16, 0.2))


def _tray(name: str, rng: np.random.Generator) -> Body:
    return shapes.tray(name, (rng.uniform(0.19, 0.3), rng.uniform(0.15, 0.21), rng.uniform(0.035, 0.06)))


def _bar(name: str, rng: np.random.Generator) -> Body:
    return shapes.bar(name, (rng.uniform(0.12, 0.24), rng.uniform(0.02, 0.035), rng.uniform(0.015, 0.025)))


KINDS: tuple[tuple[str, Maker, float], ...] = (
    ("box", _box, 0.2),
    ("flat", _flat, 0.16),
    ("can", _can, 0.14),
    ("ball", _ball, 0.05),
    ("lemon", _lemon, 0.05),
    ("bowl", _bowl, 0.1),
    ("plate", _plate, 0.07),
    ("mug", _mug, 0.06),
    ("spoon", _spoon, 0.05),
    ("tray", _tray, 0.04),
    ("bar", _bar, 0.08),
)
"""Kind, maker and share: what lies about on tables, with enough boxes to lean on."""


@dataclass(frozen=True, eq=False)
class Pile:
    """A settled pile.

    Attributes:
        bodies: The objects.
        poses: name -> (4, 4) pose_body_to_world.
    """

    bodies: tuple[Body, ...]
    poses: dict[str, FloatArray]

    @staticmethod
    def of(world: World) -> "Pile":
        """What lies on the table of a world; what fell off it is left out."""
        poses = {name: pose for name, pose in world.poses().items() if pose[2, 3] > -0.05}
        return Pile(tuple(map(world.body, poses)), poses)

    def world(self) -> World:
        """The pile on its table, in a world of its own that the caller closes."""
        world = World()
        world.add_table(size=(0.8, 0.8))
        for body in self.bodies:
            world.add(body, self.poses[body.name])
        return world


def make_pile(seed: int) -> Pile:
    """Drop household things one after the other near the middle of a table.

    Args:
        seed: Seed of kinds, sizes and places.

    Returns:
        The pile at rest; what rolled off the table is left out.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 9))
    spread = rng.uniform(0.03, 0.12)
    shares = np.array([share for _, _, share in KINDS])
    with World() as world:
        world.add_table(size=(0.8, 0.8))
        set_friction(world, 0.5, 0.6)
        for i in range(count):
            kind, make, _ = KINDS[int(rng.choice(len(KINDS), p=shares / shares.sum()))]
            body = make(f"{kind}_{i}", rng)
            _drop(world, body, rng, spread)
        set_friction(world, 0.5, 0.6)
        world.settle(4.0)
        return Pile.of(world)


def _drop(world: World, body: Body, rng: np.random.Generator, spread: float) -> None:
    """Let a body go just above the pile, and wait until it lies."""
    # Half of them are let go tipped, by 25 degrees or so: they come to lean on what they meet.
    yaw, tip = rng.uniform(0, 2 * np.pi), rng.normal(0, 0.4) if rng.random() < 0.5 else 0.0
    axis = rng.uniform(0, 2 * np.pi)
    turn = _rotation(np.array([np.cos(axis), np.sin(axis), 0.0]), tip) @ _rotation(np.array([0.0, 0, 1]), yaw)
    place = rng.normal(0, spread, 2)
    top = 0.0
    for name, pose in world.poses().items():
        if np.linalg.norm(pose[:2, 3] - place) < 0.2:
            corners = np.concatenate(world.body(name).parts) @ pose[:3, :3].T + pose[:3, 3]
            top = max(top, float(corners[:, 2].max()))
    lowest = float((np.concatenate(body.parts) @ turn.T)[:, 2].min())
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = [*place, top + 0.005 - lowest]
    world.add(body, pose)
    set_friction(world, 0.5, 0.6)
    world.settle(2.5)


def _rotation(axis: FloatArray, angle: float) -> FloatArray:
    """(3, 3) turn about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def truth(pile: Pile) -> dict[str, dict[str, int | None]]:
    """Lift every object in turn, at every friction: then -> first -> 1, 0 or None (too close to call)."""
    with pile.world() as world:
        moves: dict[str, list[Mapping[str, Move]]] = {name: [] for name in pile.poses}
        for between, table in FRICTIONS:
            set_friction(world, between, table)
            for name in pile.poses:
                moves[name].append(take_away(world, name))
    return {
        then: {first: label(found, first) for first in pile.poses if first != then}
        for then, found in moves.items()
    }


CAMERAS = np.array([[0.45, 0.31, 0.5], [-0.5, 0.235, 0.5], [0.05, -0.55, 0.5]])
"""Where depth cameras stand around a table [m]."""


def observe(pile: Pile, cameras: int, seed: int, more: FloatArray | None = None) -> Scene:
    """The pile as point clouds.

    Args:
        pile: The pile.
        cameras: How many look at it, 1 to 3; 0 gives whole surfaces without noise.
        seed: Seed of sampling and noise.
        more: (k, 3) places from where it is looked at besides [m].

    Returns:
        The scene with its table; an object no camera sees is absent.
    """
    rng = np.random.default_rng(seed)
    clouds: dict[str, FloatArray] = {}
    centres = CAMERAS[:cameras] if more is None else np.vstack([CAMERAS[:cameras], more])
    with pile.world() as world:
        for name in world.names:
            pose = world.pose(name)
            points = (
                world.body(name).surface(SAMPLES * (3 if cameras else 1), rng) @ pose[:3, :3].T + pose[:3, 3]
            )
            if name == "table":
                points = points[np.abs(points[:, 2]) < 1e-3]
            if cameras:
                points = _seen(world, name, points, centres, rng)
            if len(points) >= 30:
                clouds[name] = points[:SAMPLES] if cameras < 2 else points[: SAMPLES + 1000]
    return Scene(clouds, fixed=["table"], up=(0, 0, 1), viewpoints=centres if cameras else None)


def _seen(
    world: World, name: str, points: FloatArray, centres: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """The points some camera sees, in random order, with noise along the line of sight."""
    found: list[FloatArray] = []
    for centre in centres:
        lines = points - centre
        far = np.linalg.norm(lines, axis=1)
        hits: list[tuple[int, int, float]] = []
        ends = points + lines / far[:, None] * 0.01
        for start in range(0, len(points), 8000):
            part = ends[start : start + 8000]
            hits += pybullet.rayTestBatch(
                [centre.tolist()] * len(part), part.tolist(), physicsClientId=world.client
            )
        fraction = np.array([hit[2] for hit in hits])
        mine = np.array([hit[0] == world.ids[name] for hit in hits])
        seen = mine & (np.abs(fraction * (far + 0.01) - far) < 0.004)
        noise = rng.normal(0, NOISE, int(seen.sum()))
        found.append(points[seen] + (lines / far[:, None])[seen] * noise[:, None])
    every = np.concatenate(found)
    return every[rng.permutation(len(every))]


def label(moves: list[Mapping[str, Move]], name: str) -> int | None:
    """Did an object have to go first: 1 yes, 0 no, None too close to call.

    Args:
        moves: What moved, once per friction.
        name: The object asked about.
    """
    shares = [each[name].share for each in moves]
    if min(shares) > 1.0 and max(shares) > 1.5:
        return 1
    return 0 if max(shares) <= 1.0 and sum(share > 0.6 for share in shares) <= 1 else None
