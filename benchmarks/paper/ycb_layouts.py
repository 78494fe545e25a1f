"""Scenes 8 to 14: things of the YCB set on a table, as the paper describes its models' arrangements.

Every place and turn is drawn anew for every variant; what should touch side by side is pushed together.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.paper.stage import bring_together
from topple.benchmarks.paper.things import Things
from topple.robots.scenarios.scenario import Unlucky, pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray

DROP = 0.0005
"""Gap [m] that is left below what is put down."""


def _put(
    world: World, body: Body, at: tuple[float, float], height: float, yaw: float = 0.0, roll: float = 0.0
) -> None:
    """Put a body down with its middle over a place, rolled about its x axis, then turned."""
    turn = Rotation.from_euler("xz", [roll, yaw])
    corners = turn.apply(np.concatenate(body.parts))
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    middle = (lower + upper) / 2
    place = (at[0] - float(middle[0]), at[1] - float(middle[1]), height + DROP - float(lower[2]))
    world.add(body, pose_at(*place, turn))


def _near(rng: np.random.Generator, x: float, y: float, most: float = 0.01) -> tuple[float, float]:
    """A place [m] around another."""
    shift = rng.uniform(-most, most, 2)
    return x + float(shift[0]), y + float(shift[1])


def _turn(rng: np.random.Generator, most: float = 180.0) -> float:
    """An angle [rad] up to `most` degrees either way."""
    return float(np.radians(rng.uniform(-most, most)))


def _calm(world: World) -> None:
    """Wait before the next thing is put on top."""
    if not world.settle(3.0):
        raise Unlucky("something does not come to rest")


def _top(world: World, name: str) -> float:
    """Height of the highest point of a body [m]."""
    return float(np.concatenate(world.parts(name))[:, 2].max())


def _floor(world: World, name: str, at: FloatArray, radius: float = 0.02) -> float:
    """Height of what lies under a place inside an upright container [m], by a ray from above."""
    from topple.robots.engine import pybullet

    heights: list[float] = []
    for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        x, y = at[:2] + radius * np.array([np.cos(angle), np.sin(angle)])
        hit = pybullet.rayTest([x, y, 1.0], [x, y, -1.0], physicsClientId=world.client)[0]
        if hit[0] == world.ids[name]:
            heights.append(float(hit[3][2]))
    if not heights:
        raise Unlucky(f"{name} is not where it was put")
    return max(heights)


def scene_8(world: World, rng: np.random.Generator, things: Things) -> None:
    """A strawberry and a lemon in a bowl, a master chef can far off."""
    _put(world, things.make("bowl"), _near(rng, 0.0, 0.0, 0.02), 0.0, _turn(rng))
    away = np.radians(rng.uniform(0, 360))
    _put(world, things.make("master_chef_can"), (0.27 * np.cos(away), 0.27 * np.sin(away)), 0.0, _turn(rng))
    _calm(world)
    middle, azimuth = world.pose("bowl")[:2, 3], rng.uniform(0, 2 * np.pi)
    side = np.array([np.cos(azimuth), np.sin(azimuth)])
    for kind, reach in (("lemon", -0.035), ("strawberry", 0.026)):
        at = middle + (reach + rng.uniform(-0.003, 0.003)) * side
        yaw = azimuth + np.pi / 2 + _turn(rng, 15)
        # The scanned lemon as stored is no higher than the bowl is deep; on its side it is.
        roll = np.pi / 2 if kind == "lemon" and things.has_model(kind) else 0.0
        _put(world, things.make(kind), (at[0], at[1]), _floor(world, "bowl", at, 0.004), yaw, roll)
        _calm(world)


def scene_9(world: World, rng: np.random.Generator, things: Things) -> None:
    """A mustard bottle, a sugar box, a soup can, and a lemon on the soup can."""
    _put(world, things.make("mustard_bottle"), _near(rng, -0.12, 0.08, 0.02), 0.0, _turn(rng))
    _put(world, things.make("sugar_box"), _near(rng, 0.12, 0.09, 0.02), 0.0, _turn(rng))
    at = _near(rng, 0.01, -0.08, 0.02)
    _put(world, things.make("tomato_soup_can"), at, 0.0, _turn(rng))
    _calm(world)
    _put(world, things.make("lemon"), _near(rng, *at, 0.004), _top(world, "tomato_soup_can"), _turn(rng))


def scene_10(world: World, rng: np.random.Generator, things: Things) -> None:
    """A tuna can, close to it a gelatin box, a banana on the tuna can, two cans further off."""
    tuna, gelatin, banana = things.make("tuna_can"), things.make("gelatin_box"), things.make("banana")
    _put(world, tuna, _near(rng, 0.0, 0.0), 0.0, _turn(rng))
    _put(world, things.make("chips_can"), _near(rng, -0.18, 0.12, 0.02), 0.0, _turn(rng))
    _put(world, things.make("potted_meat_can"), _near(rng, 0.16, -0.19, 0.02), 0.0, _turn(rng))
    _calm(world)
    # The box stands upright with a broad side to the can, in the bay of the banana if there is room.
    middle, azimuth = world.pose("tuna_can")[:2, 3], _turn(rng, 25)
    side = np.array([np.cos(azimuth), np.sin(azimuth)])
    standing = np.sort(gelatin.upper - gelatin.lower)
    gap = rng.uniform(0.004, 0.007)
    at = middle + (float(tuna.upper[0]) + gap + standing[0] / 2) * side
    _stand(world, gelatin, at, azimuth)
    heavy = middle + rng.uniform(0.0, 0.012) * side  # where the banana's weight comes to lie
    yaw = azimuth + _bay(banana)
    turned = Rotation.from_euler("z", yaw).apply(banana.centre_of_mass.copy())
    height = _top(world, "tuna_can") + DROP - float(banana.lower[2])
    world.add(
        banana, pose_at(heavy[0] - turned[0], heavy[1] - turned[1], height, Rotation.from_euler("z", yaw))
    )


def scene_11(world: World, rng: np.random.Generator, things: Things) -> None:
    """A mug, a bowl and a soup can close together, an orange in the bowl."""
    bowl = things.make("bowl")
    radius = float(bowl.upper[0])
    _put(world, bowl, _near(rng, 0.0, 0.0), 0.0, _turn(rng))
    _calm(world)
    middle = world.pose("bowl")[:2, 3]
    first = rng.uniform(0, 2 * np.pi)
    for kind, half, angle in (
        ("tomato_soup_can", 0.034, first),
        ("mug", 0.041, first + rng.uniform(1.2, 2.0)),
    ):
        side = np.array([np.cos(angle), np.sin(angle)])
        at = middle + (radius + half + rng.uniform(0.006, 0.015)) * side
        body = things.make(kind)
        yaw = angle + _turn(rng, 60)  # the mug's handle stands out along +x, away from the bowl
        centre = pose_at(
            float(at[0]), float(at[1]), DROP - float(body.lower[2]), Rotation.from_euler("z", yaw)
        )
        world.add(body, centre)
    at = middle + rng.uniform(-0.006, 0.006, 2)
    _put(world, things.make("orange"), (at[0], at[1]), _floor(world, "bowl", at, 0.004), _turn(rng))


def scene_12(world: World, rng: np.random.Generator, things: Things) -> None:
    """A pear and a potted meat can on a plate, a soup can apart."""
    _put(world, things.make("plate"), _near(rng, 0.0, 0.0, 0.02), 0.0, _turn(rng))
    away = np.radians(rng.uniform(0, 360))
    _put(world, things.make("tomato_soup_can"), (0.27 * np.cos(away), 0.27 * np.sin(away)), 0.0, _turn(rng))
    _calm(world)
    middle, azimuth = world.pose("plate")[:2, 3], rng.uniform(0, 2 * np.pi)
    side = np.array([np.cos(azimuth), np.sin(azimuth)])
    for kind, reach in (("pear", -0.04), ("potted_meat_can", 0.04)):
        at = middle + (reach + rng.uniform(-0.004, 0.004)) * side
        yaw = azimuth + np.pi / 2 + _turn(rng, 15)
        _put(world, things.make(kind), (at[0], at[1]), _floor(world, "plate", at), yaw)


def scene_13(world: World, rng: np.random.Generator, things: Things) -> None:
    """Three plates stacked, a bowl on top."""
    at = _near(rng, 0.0, 0.0, 0.03)
    for number in (1, 2, 3):
        name = f"plate_{number}"
        place = np.array(_near(rng, *at, 0.0015))
        height = 0.0 if number == 1 else _floor(world, f"plate_{number - 1}", place, 0.05)
        _put(world, things.make("plate", name), (place[0], place[1]), height, _turn(rng))
        _calm(world)
    place = np.array(_near(rng, *at, 0.012))
    _put(world, things.make("bowl"), (place[0], place[1]), _floor(world, "plate_3", place, 0.03), _turn(rng))


def scene_14(world: World, rng: np.random.Generator, things: Things) -> None:
    """Two bananas side by side, a plum at one of them, a lemon aside."""
    first, second = things.make("banana", "banana_1"), things.make("banana", "banana_2")
    yaw = _turn(rng)
    at = np.array(_near(rng, 0.0, 0.0, 0.02))
    outwards = yaw - _bay(first)  # from the bay through the banana: the second lies in the bay of the first
    out = np.array([np.cos(outwards), np.sin(outwards)])
    along = np.array([-out[1], out[0]])
    _put(world, first, (at[0], at[1]), 0.0, yaw)
    beside = at + 0.052 * out + rng.uniform(-0.01, 0.01) * along
    _put(world, second, (beside[0], beside[1]), 0.0, yaw + _turn(rng, 5))
    _calm(world)
    bring_together(world, "banana_2", "banana_1")
    plum = at - 0.068 * out + rng.uniform(-0.03, 0.03) * along
    _put(world, things.make("plum"), (plum[0], plum[1]), 0.0, _turn(rng))
    away = at - 0.17 * out + rng.uniform(-0.06, 0.06) * along
    _put(world, things.make("lemon"), (away[0], away[1]), 0.0, _turn(rng))
    _calm(world)
    bring_together(world, "plum", "banana_1")


def _bay(banana: Body) -> float:
    """Angle [rad] by which a banana is turned so that its bay, the hollow side of its bend, faces +x."""
    points = np.concatenate(banana.parts)[:, :2]
    middle = (banana.lower + banana.upper)[:2] / 2
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    across = axes[:, 0]
    ends = points[np.abs(centred @ axes[:, 1]) > 0.4 * np.ptp(centred @ axes[:, 1])]
    bay = across * np.sign((ends.mean(axis=0) - middle) @ across)  # the ends stand out towards the bay
    return -float(np.arctan2(bay[1], bay[0]))


def _stand(world: World, body: Body, at: FloatArray, azimuth: float) -> None:
    """Stand a box upright, its thinnest extent along a direction."""
    extent = body.upper - body.lower
    thin, high = int(np.argmin(extent)), int(np.argsort(extent)[1])
    axes = np.zeros((3, 3))
    axes[0, thin], axes[2, high] = 1.0, 1.0
    axes[1] = np.cross(axes[2], axes[0])
    turn = Rotation.from_euler("z", azimuth) * Rotation.from_matrix(axes)
    corners = turn.apply(np.concatenate(body.parts))
    low, top = corners.min(axis=0), corners.max(axis=0)
    middle = (low + top) / 2
    place = (float(at[0] - middle[0]), float(at[1] - middle[1]), DROP - float(low[2]))
    world.add(body, pose_at(*place, turn))


LAYOUTS = {8: scene_8, 9: scene_9, 10: scene_10, 11: scene_11, 12: scene_12, 13: scene_13, 14: scene_14}
