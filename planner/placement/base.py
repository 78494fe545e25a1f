"""Where the arm should stand: reach over what is to be handled, and room to put it down."""

from collections.abc import Sequence

import numpy as np

from topple.planner.motion.collision import Checker
from topple.planner.placement.free_space import FreeSpace, free_spaces
from topple.planner.placement.placement import reachable
from topple.planner.placement.resting import PLACEMENT_TOLERANCES
from topple.planner.placement.tolerances import DIRECTIONS, DISTANCES, FOOT, HOVER, SEEDS, STEP
from topple.robots.arm.arm import Arm
from topple.robots.arm.home import scale_of
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError
from topple.topology.bodies.tops import lowest_in_use, tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.thin import voxel_means
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


class NoBase(ToppleError):
    """No place for the arm from which it reaches anything."""


def choose_base(scene: Scene | Situation, arm: Arm, targets: "tuple[str, ...]" = ()) -> FloatArray:
    """Search for a place of the arm's base.

    Places on circles around what is to be handled, on the level of the top under it, are compared by how many
    of the objects the hand reaches straight from above, by the free room on tops within reach, and by the
    distance.

    Args:
        scene: The scene, with `up`, or the situation it was read as.
        arm: The arm.
        targets: What it has to handle; everything that can move where empty.

    Returns:
        (4, 4) pose_base_to_world, z along up, x towards the objects: the best at which the arm's home touches
        nothing. Deterministic.

    Raises:
        NoBase: Nothing is reachable from anywhere.
    """
    situation = Situation.of(scene)
    scene, up = situation.scene, situation.up
    names = targets or scene.movable
    axes = np.stack(level_axes(up))
    middle = np.mean([scene.clouds[name].mean(axis=0) for name in names], axis=0)
    spaces = free_spaces(situation)
    level = _level(scene, up)
    poses = [
        _pose(axes, up, axes @ middle, level, distance, 2.0 * np.pi * k / DIRECTIONS)
        for distance in (scale_of(arm) * usual for usual in DISTANCES)
        for k in range(DIRECTIONS)
    ]
    standing = _drop_obstructed(poses, scene, axes, up, level, scale_of(arm) * FOOT)
    reached: list[tuple[float, FloatArray]] = []
    for pose, reach in zip(standing, _reach(standing, names, scene, arm, up), strict=True):
        if reach > 0.0:
            way = float(np.linalg.norm(pose[:3, 3] - middle))
            reached.append((reach + 0.3 * _room(pose, spaces, axes, scale_of(arm)) - 0.1 * way, pose))
    if not reached:
        raise NoBase(
            f"no place for {arm.name} from which it reaches {', '.join(names)}: give --base X Y Z YAW"
        )
    reached.sort(key=lambda item: -item[0])
    free = (pose for _, pose in reached if not Checker(arm, pose, situation.solids).contacts(arm.home))
    return next(free, reached[0][1])


def _level(scene: Scene, up: FloatArray) -> float:
    """Height of the lowest top that is in use, or of the lowest point of all where there is none [m]."""
    fixed = [tops_of(scene.clouds[name], up) for name in sorted(scene.fixed)]
    tops = [top for found in fixed for top in found.tops if not top.walled]
    if not tops:
        return min(float((cloud @ up).min()) for cloud in scene.clouds.values())
    return lowest_in_use(tops, [scene.clouds[name] for name in scene.movable]).height


def _pose(
    axes: FloatArray, up: FloatArray, middle: FloatArray, level: float, distance: float, turn: float
) -> FloatArray:
    """A base at a distance and direction from the middle, facing it."""
    outward = np.array([-np.cos(turn), -np.sin(turn)])
    pose = np.eye(4)
    x = axes.T @ -outward
    pose[:3, :3] = np.column_stack([x, np.asarray(np.cross(up, x), dtype=np.float64), up])
    pose[:3, 3] = axes.T @ (middle + distance * outward) + level * up
    return pose


def _drop_obstructed(
    poses: list[FloatArray], scene: Scene, axes: FloatArray, up: FloatArray, level: float, foot: float
) -> list[FloatArray]:
    """The poses at which nothing that rises above their level is where the arm's foot would be."""
    things: list[FloatArray] = []
    for name, cloud in scene.clouds.items():
        if name in scene.fixed:
            found = tops_of(cloud, up)
            higher = [top.points for top in found.tops if top.height > level + STEP]
            cloud = np.vstack([*higher, found.rest[found.rest @ up > level + STEP]])
        things.append(voxel_means(cloud, 0.01, ahead=0.0) @ axes.T)
    tree = PointTree(np.vstack([*things, scene.matter @ axes.T]))
    return [pose for pose in poses if tree.query(axes @ pose[:3, 3])[0] > foot]


def _reach(
    poses: list[FloatArray], names: "tuple[str, ...]", scene: Scene, arm: Arm, up: FloatArray
) -> list[float]:
    """Share of the objects a hand can be over, pointing down, for each base."""
    tool, hover = next(iter(arm.tools)), scale_of(arm) * HOVER
    targets: list[FloatArray] = []
    for pose in poses:
        for name in names:
            cloud = scene.clouds[name]
            target = np.eye(4)
            target[:3, :3] = np.column_stack([pose[:3, 0], -pose[:3, 1], -up])
            target[:3, 3] = cloud.mean(axis=0)
            target[:3, 3] += up * (float((cloud @ up).max()) + hover - float(target[:3, 3] @ up))
            targets.append(np.linalg.inv(pose) @ target)
    if not targets:
        return []
    solutions = arm.inverse(np.array(targets), tool, seeds=SEEDS, rng=np.random.default_rng(0))
    found = np.array([len(states) > 0 for states in solutions], dtype=np.float64)
    return [float(value) for value in found.reshape(len(poses), len(names)).mean(axis=1)]


def _room(pose: FloatArray, spaces: Sequence[FreeSpace], axes: FloatArray, scale: float) -> float:
    """Free tops within reach, as a share of the ring the arm reaches."""
    near, far = (scale * end for end in PLACEMENT_TOLERANCES.reach)
    area = 0.0
    for space in spaces:
        places = space.middles(np.argwhere(space.distance > 0.05))
        rise = space.height - float(pose[:3, 3] @ space.normal)
        within = reachable(places, rise, axes @ pose[:3, 3], scale)
        area += float(np.count_nonzero(within)) * space.cell**2
    return min(1.0, area / (np.pi * (far**2 - near**2)))
