"""What is seen is matched with what is remembered, whatever names a segmentation gives it at this look."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pytest

from topple.planner.execution.associate import associate_names, match_objects
from topple.planner.execution.look import Observer
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

SIZE = (0.05, 0.05, 0.08)
EYES = tuple(Camera.looking_at((x, y, 0.6), (0.0, 0.0, 0.0)) for x, y in ((0.6, 0.3), (-0.4, 0.6)))


def cloud(x: float, y: float, size: tuple[float, float, float] = SIZE, seed: int = 0) -> FloatArray:
    place = np.array([x, y, 0.0])
    return shapes.box("box", size).surface(1500, np.random.default_rng(seed)) + place


@pytest.fixture
def world() -> Iterator[World]:
    """Two boxes alike, 12 cm apart, and a can."""
    with World() as made:
        made.add_table()
        made.add(shapes.box("left", SIZE), pose_at(0.0, 0.06, 0.0))
        made.add(shapes.box("right", SIZE), pose_at(0.0, -0.06, 0.0))
        made.add(shapes.can("can"), pose_at(0.2, 0.0, 0.0))
        yield made


def observer(world: World, seed: int = 0) -> Observer:
    return Observer(world, EYES, np.random.default_rng(seed), ("table",), shuffle_labels=True)


def middles(scene: Scene) -> Mapping[str, FloatArray]:
    return {name: scene.clouds[name].mean(axis=0)[:2] for name in scene.movable}


def with_names(images: tuple[DepthImage, ...], names: Mapping[str, str]) -> list[DepthImage]:
    """The same images with other names: those of a segmentation that starts anew."""
    return [replace(i, names={k: names.get(name, name) for k, name in i.names.items()}) for i in images]


def test_two_alike_that_stayed_are_not_mixed_up_whatever_they_are_called(world):
    """Also where the names of this look are just the wrong way round."""
    rng = np.random.default_rng(0)
    remembered = observer(world).look().scene
    images = tuple(eye.look(world, rng) for eye in EYES)
    swapped = with_names(images, {"left": "right", "right": "left", "can": "left box"})
    for mixed in (images, swapped):
        named = Scene.from_images(associate_names(mixed, remembered, rng), fixed=["table"], up=[0, 0, 1])
        assert set(named.movable) == {"left", "right", "can"}
        assert middles(named)["left"] == pytest.approx([0.0, 0.06], abs=0.01)
        assert middles(named)["right"] == pytest.approx([0.0, -0.06], abs=0.01)


@pytest.mark.parametrize("way", [0.02, 0.10, 0.2])
def test_of_two_alike_the_one_that_moved_is_told_by_the_other_that_stayed(world, way):
    eyes = observer(world)
    before = eyes.look().scene
    world.place("left", pose_at(0.0, 0.06 + way, 0.0))
    after = eyes.look(before)
    assert middles(after.scene)["left"] == pytest.approx([0.0, 0.06 + way], abs=0.01)
    assert middles(after.scene)["right"] == pytest.approx([0.0, -0.06], abs=0.01)
    assert set(after.surprises) == {"left"}


def test_what_is_expected_elsewhere_is_found_there(world):
    """The arm put it where the other one of the two stood, and that one aside."""
    eyes = observer(world)
    before = eyes.look().scene
    world.place("right", pose_at(-0.2, -0.06, 0.0))
    world.place("left", pose_at(0.0, -0.06, 0.0))
    moved = before.with_cloud("right", before.clouds["right"] - [0.2, 0.0, 0.0])
    moved = moved.with_cloud("left", before.clouds["left"] - [0.0, 0.12, 0.0])
    after = eyes.look(moved)
    assert after.surprises == {}
    assert middles(after.scene)["left"] == pytest.approx([0.0, -0.06], abs=0.01)


def test_what_is_new_is_not_taken_for_what_may_be_hidden(world):
    eyes = observer(world)
    before = eyes.look().scene
    hidden = {"left": cloud(0.0, 0.06), "right": cloud(0.0, -0.06)}
    assert match_objects({"a": cloud(0.0, 0.2)}, hidden, gone=()) == {}
    assert match_objects({"a": cloud(0.0, 0.2)}, hidden, gone=("left",)) == {"a": "left"}
    world.add(shapes.box("late", SIZE), pose_at(0.0, -0.2, 0.0))
    after = eyes.look(before)
    assert after.surprises == {"late": "late is seen for the first time"}


def test_what_fell_far_or_looks_unlike_is_new():
    lost = {"left": cloud(0.0, 0.0)}
    assert match_objects({"a": cloud(0.5, 0.0)}, lost, gone=("left",)) == {}
    assert match_objects({"a": cloud(0.1, 0.0, (0.3, 0.3, 0.02))}, lost, gone=("left",)) == {}
    assert match_objects({}, lost, gone=("left",)) == {} == match_objects({"a": cloud(0.0, 0.0)}, {}, gone=())


def test_a_new_object_does_not_take_the_name_of_one_that_is_remembered(world):
    """One alike has come where the can was; the can is gone too far to be known again."""
    eyes = observer(world)
    before = eyes.look().scene
    world.place("can", pose_at(-0.2, 0.2, 0.0))
    seen = eyes.look(before).scene
    assert set(seen.movable) == {"left", "right", "can (2)"}


@pytest.mark.parametrize("seed", range(3))
def test_clouds_are_matched_one_to_one_in_any_order(seed):
    rng = np.random.default_rng(seed)
    places = {f"box {k}": rng.uniform(-0.4, 0.4, 2) for k in range(6)}
    remembered = {name: cloud(*place) for name, place in places.items()}
    nudged = {name: cloud(*(place + rng.normal(0.0, 0.004, 2)), seed=1) for name, place in places.items()}
    order = list(nudged)
    rng.shuffle(order)
    seen = {f"segment {k}": nudged[name] for k, name in enumerate(order)}
    assert match_objects(seen, remembered, gone=()) == {f"segment {k}": name for k, name in enumerate(order)}
