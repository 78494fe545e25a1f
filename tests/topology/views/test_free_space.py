"""What cameras saw to be empty: the same in every frame, and nothing where no light came back."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.topology.relations.relate import relate
from topple.topology.views.free_space import FreeSpace
from topple.topology.views.image import DepthImage

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import moved, pile, seen, told

ACROSS = np.linspace(-0.2, 0.2, 81)
WALL = np.stack(np.meshgrid(ACROSS, ACROSS, [0.0]), axis=-1).reshape(-1, 3)
EYE = np.array([[0.0, 0.0, 1.0]])


def picture(depth: np.ndarray) -> DepthImage:
    """From a metre above, straight down."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 1.0
    K = np.array([[500.0, 0.0, 49.5], [0.0, 500.0, 49.5], [0.0, 0.0, 1.0]])
    return DepthImage(depth, K, np.zeros(depth.shape, dtype=np.int64), pose)


@pytest.mark.parametrize("cameras", [1, pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("images", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_turn_about_the_vertical_changes_no_relation_and_nothing_observed(cameras, images):
    unseen, changed = 0, list[int]()
    for seed in range(25):
        rng = np.random.default_rng(seed)
        scene = seen(pile(rng), rng, cameras, images)
        turn = Rotation.from_euler("z", rng.uniform(0.2, 6.0)).as_matrix()
        before = told(relate(scene))
        if told(relate(moved(scene, turn, np.zeros(3)))) != before:
            changed.append(seed)
        unseen += sum(not observed for _, observed, _ in before.values())
    assert unseen > 0
    assert len(changed) <= 1, changed  # what lies on a limit falls to either side


def test_where_nothing_came_back_is_unknown():
    """The wall ends at 20 cm: beyond it a camera without a picture saw nothing, far or near."""
    beside = np.array([[0.12, 0.0, 0.5], [0.2, 0.0, 0.5]])
    assert FreeSpace({"wall": WALL}, EYE).empty(beside).tolist() == [False, False]
    assert FreeSpace({"wall": WALL}, EYE).empty(beside / 3).tolist() == [True, True]


def test_a_picture_shows_what_no_object_s_cloud_does_and_a_pixel_without_depth_shows_nothing():
    depth = np.ones((100, 100))
    depth[:, 70:] = 0.0
    places = np.array([[0.0, 0.0, 0.5], [0.03, 0.0, 0.5], [0.2, 0.0, 0.5]])
    cup = np.array([[0.3, 0.3, 0.01]])
    assert FreeSpace({"cup": cup}, EYE).empty(places).tolist() == [False, False, False]
    assert FreeSpace({"cup": cup}, EYE, [picture(depth)]).empty(places).tolist() == [True, False, False]


def test_what_came_since_the_picture_was_taken_ends_its_lines_of_sight():
    places = np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.8], [0.08, 0.0, 0.1]])
    space = FreeSpace({"wall": WALL}, EYE, [picture(np.ones((100, 100)))])
    assert space.empty(places).tolist() == [True, True, True]
    lid = WALL / 10 + [0.0, 0.0, 0.5]
    assert space.with_clouds({"lid": lid}).empty(places).tolist() == [False, True, True]
    assert FreeSpace({"wall": WALL, "lid": lid}, EYE, [picture(np.ones((100, 100)))]).empty(
        places
    ).tolist() == [False, True, True]


def test_a_frame_of_its_own_sees_the_same():
    rng = np.random.default_rng(0)
    scene = seen(pile(rng), rng, 2)
    turn = Rotation.random(random_state=1).as_matrix()
    turned = FreeSpace(
        {name: cloud @ turn.T for name, cloud in scene.clouds.items()}, scene.viewpoints, scene.images, turn
    )
    places = rng.uniform([-0.2, -0.2, -0.05], [0.2, 0.2, 0.2], (500, 3))
    straight = FreeSpace(scene.clouds, scene.viewpoints, scene.images)
    assert turned.empty(places @ turn.T).tolist() == straight.empty(places).tolist()
    assert 0.1 < straight.empty(places).mean() < 0.9
    outward = rng.normal(size=(500, 3))
    assert (
        turned.faces(places @ turn.T, outward @ turn.T).tolist() == straight.faces(places, outward).tolist()
    )
