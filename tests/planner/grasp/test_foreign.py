from pathlib import Path

import numpy as np
import pytest

from topple.planner.grasp.foreign import grasps_from_array, read_grasps
from topple.topology.errors import InvalidInput


def down(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = [x, y, z]
    return pose


def test_graspnet_rows_approach_along_their_x_and_close_along_their_y(tmp_path: Path) -> None:
    approach, closing = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    rotation = np.column_stack([approach, closing, np.cross(approach, closing)])
    row = [0.8, 0.06, 0.02, 0.03, *rotation.ravel(), 0.1, 0.2, 0.5, -1.0]
    np.save(tmp_path / "g.npy", np.array([row]))
    grasps = read_grasps(tmp_path / "g.npy")
    pose = grasps.poses_tool_to_source[0]
    assert grasps.source == "graspnet"
    assert np.allclose(pose[:3, 2], approach)
    assert np.allclose(pose[:3, 1], closing)
    assert np.allclose(pose[:3, 3], [0.1, 0.2, 0.52])
    assert grasps.scores[0] == 0.8
    assert grasps.widths[0] == 0.06


def test_contact_graspnet_poses_are_of_the_hand_with_its_x_closing(tmp_path: Path) -> None:
    np.savez(tmp_path / "g.npz", pred_grasps_cam=np.eye(4)[None], scores=np.array([0.5]))
    pose = read_grasps(tmp_path / "g.npz").poses_tool_to_source[0]
    assert np.allclose(pose[:3, 1], [1.0, 0.0, 0.0])
    assert np.allclose(pose[:3, 3], [0.0, 0.0, 0.1034])
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)


def test_pickles_are_refused_and_not_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "g.npz", pred_grasps_cam=np.array({1: np.eye(4)[None]}, dtype=object))
    with pytest.raises(InvalidInput, match="never loaded"):
        read_grasps(tmp_path / "g.npz")


def test_isaac_grasp_reads_quaternions_and_confidence(tmp_path: Path) -> None:
    pytest.importorskip("yaml", reason="isaac_grasp files need PyYAML")
    text = (
        "format: isaac_grasp\nformat_version: 1.0\ngrasps:\n  grasp_0:\n    confidence: 0.7\n"
        "    position: [0.1, 0.0, 0.0]\n    orientation: {w: 1.0, xyz: [0.0, 0.0, 0.0]}\n"
    )
    (tmp_path / "g.yaml").write_text(text)
    grasps = read_grasps(tmp_path / "g.yaml")
    assert grasps.scores[0] == 0.7
    assert np.allclose(grasps.poses_tool_to_source[0][:3, 3], [0.1, 0.0, 0.1034])


def test_plain_poses_come_with_scores() -> None:
    grasps = grasps_from_array(np.array([down(), down(0.1)]), scores=[0.2, 0.9])
    assert len(grasps) == 2
    assert np.array_equal(grasps.scores, [0.2, 0.9])


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.zeros((3, 5)), "expected"),
        (np.array([np.full((4, 4), np.nan)]), "not finite"),
        (np.array([down(500.0)]), "metres"),
        (np.array([np.diag([-1.0, 1.0, 1.0, 1.0])]), "left-handed"),
        (np.array([np.diag([2.0, 1.0, 1.0, 1.0])]), "rotation"),
    ],
)
def test_wrong_shapes_units_and_frames_are_named(array: np.ndarray, words: str) -> None:
    with pytest.raises(InvalidInput, match=words):
        grasps_from_array(array)


def test_files_that_are_no_grasps_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.npy").write_bytes(b"nothing")
    with pytest.raises(InvalidInput, match="no file of grasps"):
        read_grasps(tmp_path / "a.npy")
    with pytest.raises(InvalidInput, match="cannot be read"):
        read_grasps(tmp_path / "missing.npy")
