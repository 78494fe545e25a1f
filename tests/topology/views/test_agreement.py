"""Pictures of several cameras at poses that are right, nearly right, and wrong in the usual ways."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

sys.path.insert(0, str(Path(__file__).parents[1]))
from made import EYES, UP, look, pile

OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


def _views(seed: int, count: int = 2) -> list[DepthImage]:
    rng = np.random.default_rng(seed)
    boxes = pile(rng)
    return [look(boxes, eye, rng) for eye in EYES[:count]]


def _at(views: list[DepthImage], *poses: np.ndarray) -> list[DepthImage]:
    return [replace(view, pose_camera_to_world=pose) for view, pose in zip(views, poses, strict=True)]


def _scene(views: list[DepthImage]) -> Scene:
    return Scene.from_images(views, fixed=["table"], up=UP)


def _moved(pose: np.ndarray, shift: float, turn: float, rng: np.random.Generator) -> np.ndarray:
    """A pose shifted by so much [m], and turned about its camera by so much [rad], in any direction."""
    (along, about), moved = rng.normal(size=(2, 3)), pose.copy()
    moved[:3, 3] += shift * along / np.linalg.norm(along)
    moved[:3, :3] = moved[:3, :3] @ Rotation.from_rotvec(turn * about / np.linalg.norm(about)).as_matrix()
    return moved


@pytest.mark.parametrize("seed", range(2))
def test_poses_that_are_off_by_what_calibrations_are_off_by_are_taken(seed):
    views, rng = _views(seed, 3), np.random.default_rng(seed)
    poses = [_moved(view.pose_camera_to_world, 0.01, np.radians(1.0), rng) for view in views]
    for some in (views, _at(views, *poses)):
        assert len(_scene(some).viewpoints) == 3


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_pose_that_is_off_by_four_centimetres_is_refused(seed):
    first, second = _views(seed)
    moved = _moved(second.pose_camera_to_world, 0.04, 0.0, np.random.default_rng(seed))
    with pytest.raises(InvalidInput, match=r"views 1 and 2 disagree: one would fit [34] cm aside; give"):
        _scene([first, replace(second, pose_camera_to_world=moved)])


WRONG = {
    "both poses are in OpenGL axes": lambda a, b: (a @ OPENGL, b @ OPENGL),
    "the pose of view 2 is in OpenGL axes": lambda a, b: (a, b @ OPENGL),
    "both poses are inverted, world to camera": lambda a, b: (np.linalg.inv(a), np.linalg.inv(b)),
    "the pose of view 1 is inverted, world to camera": lambda a, b: (np.linalg.inv(a), b),
    "their poses are swapped": lambda a, b: (b, a),
    "give each its own pose_camera_to_world": lambda a, b: (a, np.eye(4)),
    "disagree": lambda a, b: (np.eye(4), np.eye(4)),
}


ONE = "the pose of view 1 is inverted, world to camera"  # as one in OpenGL axes, by the same search


@pytest.mark.parametrize(
    "words", [pytest.param(each, marks=pytest.mark.slow) if each == ONE else each for each in WRONG]
)
def test_poses_of_other_conventions_are_refused_with_the_one_that_fits(words):
    views = _views(0)
    poses = WRONG[words](*(view.pose_camera_to_world for view in views))
    with pytest.raises(InvalidInput, match=f"views 1 and 2 disagree.*{words}|views 1 and 2 {words}"):
        _scene(_at(views, *poses))
