"""Scenes 1 to 7: boxes, books, a jar and bars that lie, stand and lean, as the paper describes its pictures.

Sizes and places are of our making: the paper gives no measures. Every place, turn and tilt is drawn anew for
every variant.
"""

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.paper.things import Things
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import bar, box, can, cup, tray
from topple.robots.world.bodies import Color
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray

Size = tuple[float, float, float]

BLUE: Color = (0.25, 0.4, 0.7, 1.0)
RED: Color = (0.75, 0.3, 0.25, 1.0)
GREEN: Color = (0.35, 0.6, 0.35, 1.0)
STEEL: Color = (0.7, 0.72, 0.75, 1.0)
WALL: Color = (0.9, 0.9, 0.86, 1.0)
DROP = 0.0005
"""Gap [m] that is left below what is put down."""

WALLS = ("wall_1", "wall_2")
"""What stands in the background of scene 3: no objects of the scene."""


def _turn(rng: np.random.Generator, most: float) -> float:
    """An angle [rad] up to `most` degrees either way."""
    return float(np.radians(rng.uniform(-most, most)))


def _jitter(rng: np.random.Generator, most: float = 0.01) -> FloatArray:
    """(2,) a shift along the ground [m]."""
    return rng.uniform(-most, most, 2)


def _laid(at: FloatArray, yaw: float, height: float = 0.0) -> FloatArray:
    """(4, 4) pose of something put down at (x, y) and a height [m]."""
    return pose_at(float(at[0]), float(at[1]), height + DROP, Rotation.from_euler("z", yaw))


def _leaning(size: Size, face: float, edge: float, tilt: float, aside: float, azimuth: float) -> FloatArray:
    """Pose of a board that leans with its broad face on the upper edge of something.

    Args:
        size: Thickness, width and length of the board [m].
        face: Distance of the thing's upright face from its middle [m].
        edge: Height of its upper edge [m].
        tilt: Angle of the board with the ground [rad].
        aside: Shift along the edge [m].
        azimuth: Direction [rad] from the thing's middle to the face.

    Returns:
        (4, 4) pose_board_to_thing.
    """
    outwards = np.array([np.sin(tilt), 0.0, np.cos(tilt)])  # from the face that leans to the other one
    foot = np.array([face + edge / np.tan(tilt), aside, 0.0])
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("y", tilt - np.pi / 2).as_matrix()
    pose[:3, 3] = foot + (size[0] / 2 + DROP) * outwards + [0.0, 0.0, DROP]
    around = np.eye(4)
    around[:3, :3] = Rotation.from_euler("z", azimuth).as_matrix()
    return around @ pose


def _lying_with(
    world: World, rng: np.random.Generator, lying: Size, boards: Mapping[str, tuple[Size, float, float]],
    colors: tuple[Color, ...] = (RED, GREEN, BLUE),
) -> FloatArray:  # fmt: skip
    """A lying box and boards that lean on it: name -> (size, azimuth [degrees], shift along the edge [m])."""
    pose = _laid(_jitter(rng, 0.02), _turn(rng, 12))
    world.add(box("lying", lying), pose)
    for (name, (size, azimuth, aside)), color in zip(boards.items(), colors, strict=False):
        face = lying[0] / 2 if azimuth % 180 == 0 else lying[1] / 2
        tilt = np.radians(rng.uniform(56, 66))
        shift = aside + rng.uniform(-0.008, 0.008)
        leaning = _leaning(size, face, lying[2], tilt, shift, np.radians(azimuth))
        world.add(box(name, size, color=color), pose @ leaning)
    return pose


def _upright(world: World, rng: np.random.Generator, size: Size, pose: FloatArray, at: tuple[float, float],
             height: float, name: str = "upright") -> None:  # fmt: skip
    """Stand a box on what lies at a pose."""
    place = _laid(np.array(at) + _jitter(rng, 0.006), _turn(rng, 15), height)
    world.add(box(name, size, color=BLUE), pose @ place)


def scene_1(world: World, rng: np.random.Generator, things: Things) -> None:
    """A box lies, one leans on it, one stands on it."""
    lying = (0.28, 0.19, 0.10)
    pose = _lying_with(world, rng, lying, {"leaning": ((0.035, 0.11, 0.19), 0, 0.0)})
    _upright(world, rng, (0.075, 0.055, 0.15), pose, (-0.05, 0.0), lying[2])


def scene_2(world: World, rng: np.random.Generator, things: Things) -> None:
    """The same with other boxes, seen from elsewhere: the leaning one is at a long side."""
    lying = (0.30, 0.20, 0.08)
    pose = _lying_with(world, rng, lying, {"leaning": ((0.05, 0.09, 0.16), -90, 0.06)})
    _upright(world, rng, (0.10, 0.05, 0.17), pose, (-0.06, 0.02), lying[2])


def scene_3(world: World, rng: np.random.Generator, things: Things) -> None:
    """Near the corner of two walls: a box, a book that lies on it and one that leans on that book."""
    wall = np.array([[-0.22, 0.0, 0.0], [0.0, -0.22, 0.0]])
    for name, place, size in zip(WALLS, wall, ((0.02, 0.85, 0.5), (0.85, 0.02, 0.5)), strict=True):
        world.add(box(name, size, color=WALL), pose_at(*place.tolist()), fixed=True)
    case = (0.30, 0.24, 0.14)
    pose = _laid(np.array([-0.03, -0.06]) + _jitter(rng), _turn(rng, 4))
    world.add(box("box", case), pose)
    book, other = (0.14, 0.20, 0.035), (0.022, 0.15, 0.11)
    at = np.array([-0.06, 0.0]) + _jitter(rng, 0.006)
    world.add(box("book_1", book, color=RED, density=700), pose @ _laid(at, _turn(rng, 5), case[2]))
    leaning = _leaning(other, book[0] / 2, book[2], np.radians(rng.uniform(52, 60)), 0.0, 0.0)
    leaning[:3, 3] += [at[0], at[1], case[2] + 2 * DROP]
    world.add(box("book_2", other, color=BLUE, density=700), pose @ leaning)


def scene_4(world: World, rng: np.random.Generator, things: Things) -> None:
    """A box, a hollow jar on it, a rod that leans in the jar."""
    case = (0.24, 0.20, 0.09)
    pose = _laid(_jitter(rng, 0.02), _turn(rng, 20))
    world.add(box("box", case), pose)
    at = _jitter(rng, 0.02)
    world.add(cup("jar", diameter=0.095, height=0.11, sides=24, color=STEEL), pose @ _laid(at, 0.0, case[2]))
    tilt, azimuth = np.radians(rng.uniform(10, 13)), rng.uniform(0, 2 * np.pi)
    towards = np.array([np.cos(azimuth), np.sin(azimuth)])
    floor = case[2] + 0.0055 + 0.009 * np.sin(tilt)  # the jar's, and the rim of the tilted rod's end
    rod = _laid(at - 0.02 * towards, azimuth, floor)
    rod[:3, :3] = rod[:3, :3] @ Rotation.from_euler("y", tilt).as_matrix()
    world.add(can("rod", diameter=0.018, height=0.21, sides=16, color=RED), pose @ rod)


def scene_5(world: World, rng: np.random.Generator, things: Things) -> None:
    """A hollow box with a bar in it that sticks out, and a solid box that leans on the hollow one."""
    hollow = (0.22, 0.17, 0.10)
    pose = _laid(_jitter(rng, 0.02), _turn(rng, 12))
    world.add(tray("hollow_box", hollow, wall=0.006, mass=0.5), pose)
    size = (0.045, 0.10, 0.17)
    tilt = np.radians(rng.uniform(58, 66))
    leaning = _leaning(size, hollow[0] / 2, hollow[2], tilt, rng.uniform(-0.01, 0.01), 0.0)
    world.add(box("solid_box", size, color=GREEN), pose @ leaning)
    # The bar's foot stands on the floor, and the bar lies on the inner edge of a wall's rim.
    stick, wall = (0.024, 0.03, 0.25), 0.006
    edge, inner = hollow[2] - wall, hollow[1] / 2 - wall
    inside = _leaning(
        stick, -inner, edge, np.radians(rng.uniform(37, 41)), rng.uniform(0.02, 0.05), np.pi / 2
    )
    inside[2, 3] += wall
    world.add(bar("bar", stick, color=BLUE), pose @ inside)


def scene_6(world: World, rng: np.random.Generator, things: Things) -> None:
    """Five boxes crowded: one lies, three lean on it, one stands on it."""
    lying = (0.30, 0.22, 0.09)
    boards = {
        "leaning_1": ((0.035, 0.10, 0.17), 0, 0.02),
        "leaning_2": ((0.04, 0.09, 0.15), 90, -0.06),
        "leaning_3": ((0.03, 0.11, 0.18), -90, 0.06),
    }
    pose = _lying_with(world, rng, lying, boards, (RED, GREEN, STEEL))
    _upright(world, rng, (0.09, 0.055, 0.16), pose, (-0.07, 0.01), lying[2])


def scene_7(world: World, rng: np.random.Generator, things: Things) -> None:
    """One lies, two lean on it, one stands apart."""
    lying = (0.26, 0.18, 0.11)
    boards = {"leaning_1": ((0.04, 0.10, 0.18), 0, 0.0), "leaning_2": ((0.03, 0.12, 0.17), 90, 0.0)}
    pose = _lying_with(world, rng, lying, boards, (RED, GREEN))
    _upright(world, rng, (0.10, 0.07, 0.13), pose, (-0.26, -0.06), 0.0, name="apart")


LAYOUTS = {1: scene_1, 2: scene_2, 3: scene_3, 4: scene_4, 5: scene_5, 6: scene_6, 7: scene_7}
