"""Containers with their content where it lies at rest, upright and tilted, whole and as cameras see them."""

import numpy as np
import pytest

from topple.robots import shapes
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

UP = (0.0, 0.0, 1.0)
EYES = ((0.25, -0.15, 0.7), (-0.4, 0.4, 0.55), (-0.4, -0.4, 0.55))  # [m] the first alone is the single view
VIEW = float(np.radians(35))  # the pixels of a wider picture, without its margin
Placed = list[tuple[Body, FloatArray]]


def pose(x: float, y: float, z: float, tilt: float = 0.0) -> FloatArray:
    """(4, 4) turned about y by `tilt` [degrees] and moved [m]."""
    sine, cosine = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    return np.array([[cosine, 0, sine, x], [0, 1, 0, y], [-sine, 0, cosine, z], [0, 0, 0, 1.0]])


def holding(container: Body, content: Body, floor: float, tilt: float, turned: float = 0.0) -> Placed:
    """The content on the middle of the container's floor, and both on the table, tilted together."""
    frame = pose(0, 0, 0, tilt)
    frame[2, 3] = -min(float((part @ frame[2, :3]).min()) for part in container.parts)
    lying = pose(0, 0, 0, turned)
    lying[:3, 3] = -lying[:3, :3] @ (content.lower + content.upper) / 2  # centred, and then lifted
    lying[2, 3] += floor + float(np.abs(lying[2, :3]) @ (content.upper - content.lower)) / 2
    return [(container, frame), (content, frame @ lying)]


def whole(placed: Placed) -> Scene:
    """Every surface all around, with half a millimetre of noise."""
    rng = np.random.default_rng(0)
    clouds = {"table": np.c_[rng.uniform(-0.4, 0.4, (12_000, 2)), rng.normal(0, 0.0005, 12_000)]}
    for body, place in placed:
        points = body.surface(6000, rng) @ place[:3, :3].T + place[:3, 3]
        clouds[body.name] = points + rng.normal(0, 0.0005, points.shape)
    return Scene(clouds, fixed=["table"], up=UP)


def as_seen(placed: Placed) -> list[Scene]:
    """The scene from all cameras and from the first one alone, with the faults of a depth camera."""
    with World() as world:
        world.add_table(size=(0.8, 0.8))
        for body, place in placed:
            world.add(body, place, fixed=True)
        rng = np.random.default_rng(0)
        cameras = [Camera.looking_at(eye, (0.0, 0.0, 0.03), width=320, height=240, fov=VIEW) for eye in EYES]
        images = [camera.look(world, rng) for camera in cameras]
    return [Scene.from_images(some, fixed=["table"], up=UP) for some in (images, images[:1])]


def relations(placed: Placed) -> dict[str, Relation]:
    """How the second body lies to the first, by how much of them is known; both rules' tellings agree."""
    (first, _), (second, _) = placed
    found: dict[str, Relation] = {}
    for known, scene in zip(("whole", "3 views", "1 view"), [whole(placed), *as_seen(placed)], strict=True):
        pair = relate(scene).between(second.name, first.name)
        assert pair.converse.relation is pair.relation.converse
        found[known] = pair.relation
    return found


BOWL = {"small": (0.14, 0.055), "usual": (0.16, 0.06), "salad": (0.24, 0.09), "shallow": (0.20, 0.045)}
FLOOR = 0.005  # [m] of bowls and mugs, a little above what they measure


def bowl(size: str) -> Body:
    diameter, height = BOWL[size]
    return shapes.bowl(diameter=diameter, height=height)


@pytest.mark.parametrize("tilt", [20.0, pytest.param(0.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "container",
    [bowl("small"), bowl("salad"), shapes.mug(diameter=0.1, height=0.07)],
    ids=["small bowl", "salad bowl", "mug"],
)
def test_a_strawberry_below_the_rim_is_within(container, tilt):
    found = relations(holding(container, shapes.strawberry(), FLOOR, tilt))
    assert set(found.values()) == {Relation.WITHIN}, found


@pytest.mark.parametrize(
    ("container", "content", "turned"),
    [
        (bowl("usual"), shapes.orange(), 0.0),
        (bowl("shallow"), shapes.lemon(), 0.0),
        (shapes.mug(diameter=0.085, height=0.06), shapes.lemon(), 90.0),
    ],
    ids=["orange in a bowl", "lemon in a shallow bowl", "lemon upright in a mug"],
)
def test_what_sticks_out_is_partial_within(container, content, turned):
    found = relations(holding(container, content, FLOOR, 0.0, turned))
    assert set(found.values()) == {Relation.PARTIAL_WITHIN}, found
    tilted = relate(whole(holding(container, content, FLOOR, 20.0, turned)))
    assert tilted.between(content.name, container.name).relation is Relation.PARTIAL_WITHIN


@pytest.mark.parametrize("length", [0.22, pytest.param(0.16, marks=pytest.mark.slow)])
@pytest.mark.parametrize("apart", [0.0, 0.03])
def test_a_banana_contains_nothing(length, apart):
    banana, ball = shapes.banana(length=length), shapes.ball(diameter=0.04)
    middle = banana.parts[3].mean(axis=0)  # of the seven along it
    bend = pose(middle[0], middle[1] - 0.018 - 0.02 - apart, 0.0)  # their radii
    found = relations([(banana, np.eye(4)), (ball, bend)])
    assert found["whole"] is (Relation.DISJOINT if apart else Relation.TOUCH)
    assert not set(found.values()) - {Relation.TOUCH, Relation.DISJOINT}, found


def test_what_lies_under_the_arch_of_a_banana_is_not_in_it():
    banana, ball = shapes.banana(length=0.22), shapes.ball(diameter=0.025)
    standing = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0.0], [0, 0, 0, 1]])
    standing[2, 3] = -float(banana.lower[1])
    pair = relate(whole([(banana, standing), (ball, np.eye(4))])).between("ball", "banana")
    assert pair.relation in (Relation.TOUCH, Relation.DISJOINT)
