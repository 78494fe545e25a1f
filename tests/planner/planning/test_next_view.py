"""Where to look next: the places that no camera saw, and a view that shows them."""

import sys
from pathlib import Path

import numpy as np
import pytest

from topple.planner.cli.main import main
from topple.planner.decide.words import side_of
from topple.planner.planning.next_view import next_view, next_views
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

sys.path.insert(0, str(Path(__file__).parents[2] / "topology"))
from made import EYES, Box, moved, seen, whole

HIDING = {
    "wall": Box(np.array([0.03, -0.06, 0.08]), np.array([0.16, 0.04, 0.16]), 0.0),
    "low": Box(np.array([0.02, 0.03, 0.03]), np.array([0.06, 0.06, 0.06]), 0.0),
    "upper": Box(np.array([0.02, 0.03, 0.085]), np.array([0.05, 0.05, 0.05]), 0.0),
}
"""A tall box before two that stand on each other, as the first camera sees them."""


@pytest.fixture(scope="module")
def hidden() -> Scene:
    return seen(HIDING, np.random.default_rng(1), 1)


def test_the_next_view_is_on_the_other_side_of_what_hides(hidden):
    view = next_view(hidden)
    assert view is not None
    before = EYES[0] - view.target
    now = view.eye - view.target
    assert before[:2] @ now[:2] < 0
    assert {"low", "upper"} in [{one.a, one.b} for one in view.shows]
    again = next_views(hidden, viewpoints=np.stack([EYES[0], view.eye]))
    assert again[0].worth == pytest.approx(view.worth, abs=1e-6)
    assert len(again) == 1 or again[1].worth < 0.3 * view.worth
    np.testing.assert_allclose(view.pose_camera_to_scene[:3, 3], view.eye)
    forward = (view.target - view.eye) / np.linalg.norm(view.target - view.eye)
    np.testing.assert_allclose(view.pose_camera_to_scene[:3, 2], forward, atol=1e-9)
    assert view.pose_camera_to_scene[2, 1] < 0  # the picture's down is down


def test_a_view_turns_with_the_scene(hidden):
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([0.4, -0.2, 0.1])
    view, turned = next_view(hidden), next_view(moved(hidden, turn, shift))
    assert view is not None and turned is not None
    np.testing.assert_allclose(turned.eye, view.eye @ turn.T + shift, atol=1e-6)


def test_where_nothing_is_hidden_no_view_is_worth_a_look():
    assert next_view(whole(HIDING, np.random.default_rng(1))) is None


def test_places_that_are_none_are_refused(hidden):
    with pytest.raises(InvalidInput, match="viewpoints"):
        next_view(hidden, viewpoints=np.zeros((2, 2)))


def test_the_command_tells_it(hidden, tmp_path, typed):
    path = tmp_path / "hidden.npz"
    np.savez(path, **hidden.clouds, fixed=["table"], up=hidden.up, viewpoints=hidden.viewpoints)
    told = typed("order", path, "--next-view", "--json").document["next_view"]
    assert 0 < told["worth"] <= 1 and len(told["eye"]) == 3 and told["shows"]
    out = " ".join(typed("order", path, "--next-view").out.split())
    assert f"Next view: {told['from']}, (" in out and f"Look {told['from']}: where it meets" in out
    assert main(["show", str(path), "-o", str(tmp_path / "page.html")]) == 0
    assert f"Next view: {told['from']}, (" in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize(
    ("way", "side"),
    [((1, 0.2, 0), "right"), ((-1, 0.2, 0.5), "left"), ((0.1, -1, 0), "front"), ((0.1, 0.2, 2), "above")],
)
def test_a_side_is_as_the_camera_has_it(way, side):
    up, right = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    assert side_of(np.array(way), right, up).endswith(side)
    assert side_of(np.array([0.0, 1.0, 0.0]), right, up) == "from behind"
