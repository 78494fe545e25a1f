from pathlib import Path

import numpy as np
import pytest

from topple.planner.grasp.foreign import grasps_from_array, read_grasps
from topple.planner.grasp.rank import rank_grasps
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene


def down(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = [x, y, z]
    return pose


def test_graspnet_rows_approach_along_their_x_and_close_along_their_y(tmp_path):
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


def test_contact_graspnet_poses_are_of_the_hand_with_its_x_closing(tmp_path):
    np.savez(tmp_path / "g.npz", pred_grasps_cam=np.eye(4)[None], scores=np.array([0.5]))
    pose = read_grasps(tmp_path / "g.npz").poses_tool_to_source[0]
    assert np.allclose(pose[:3, 1], [1.0, 0.0, 0.0])
    assert np.allclose(pose[:3, 3], [0.0, 0.0, 0.1034])
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)


def stored(path: Path, **members: object) -> Path:
    """What `np.savez` makes of dicts, as Contact-GraspNet does."""
    np.savez(path, **members)  # type: ignore[arg-type]
    return path


def test_contact_graspnet_files_are_dicts_by_segment(tmp_path):
    hands = {
        1.0: np.array([down(0.1), down(0.2)], dtype=np.float32),
        np.uint8(3): np.array([down(0.3)]),
        4: np.array([]),
    }
    path = stored(
        tmp_path / "predictions.npz",
        pc_full=np.zeros((9, 3)),
        pred_grasps_cam=hands,
        scores={1.0: np.array([0.5, 0.25], dtype=np.float32), 3: np.array([0.75]), 4: np.array([])},
        contact_pts={1.0: np.zeros((2, 3)), 3: np.zeros((1, 3)), 4: np.array([])},
        gripper_openings={1.0: np.array([0.04, 0.05]), 3: np.array([[0.08]]), 4: np.array([])},
    )
    grasps = read_grasps(path)
    assert grasps.source == "contact_graspnet"
    assert grasps.labels == ("1", "1", "3")
    assert np.allclose(grasps.scores, [0.5, 0.25, 0.75])
    assert np.allclose(grasps.widths, [0.04, 0.05, 0.08])
    assert np.allclose(grasps.poses_tool_to_source[:, 0, 3], [0.1, 0.2, 0.3])
    assert np.allclose(grasps.poses_tool_to_source[:, 2, 3], -0.1034)


def test_contact_graspnet_without_segments_names_nothing(tmp_path):
    path = stored(tmp_path / "g.npz", pred_grasps_cam={-1: np.eye(4)[None]}, scores={-1: np.ones(1)})
    assert read_grasps(path).labels == ("",)


EYE, CAM = np.eye(4)[None], "pred_grasps_cam"


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({CAM: {1: np.zeros((2, 3, 4))}}, r"segment 1: pred_grasps_cam has shape \(2, 3, 4\)"),
        ({CAM: {1: EYE}, "scores": {2: np.ones(1)}}, "segment 1: has grasps but no scores"),
        ({CAM: {1: EYE}, "scores": {1: np.ones(2)}}, r"1 grasps but scores of shape \(2,\)"),
        ({CAM: {1: EYE}, "gripper_openings": {1: np.ones((1, 2))}}, "1 grasps but gripper_openings"),
        ({CAM: {1.5: EYE}}, "a segment is 1.5: expected a whole number"),
        ({CAM: {(1, 2): EYE}}, "a key is neither number nor text"),
        ({CAM: {1: [1.0, 2.0]}}, "its entry '1' is no array of numbers"),
        ({CAM: {1: {2: EYE}}}, "its entry '1' is no array of numbers"),
        ({CAM: {1: np.array(["a"])}}, "its arrays are of <U1"),
        ({CAM: EYE, "scores": np.ones(2)}, r"scores of shape \(2,\)"),
        ({CAM: EYE, "scores": np.array([np.nan])}, "grasp 0 has no finite score"),
        ({CAM: {1: EYE}, "gripper_openings": {1: -np.ones(1)}}, "negative or infinite width"),
        ({"poses": {1: EYE}}, "poses and scores are dicts"),
        ({"other": np.eye(4)}, "has other: expected pred_grasps_cam or poses"),
    ],
)
def test_wrong_contact_graspnet_files_are_refused_in_a_line(tmp_path, members, words):
    with pytest.raises(InvalidInput, match=words):
        read_grasps(stored(tmp_path / "g.npz", **members))


def test_graspnet_rows_name_their_objects(tmp_path):
    row = [0.8, 0.06, 0.02, 0.03, *np.eye(3).ravel(), 0.1, 0.2, 0.5]
    grasps = grasps_from_array(np.array([[*row, 5.0], [*row, -1.0]]))
    assert grasps.labels == ("5", "")
    with pytest.raises(InvalidInput, match=r"object of grasp 0 is 0\.5"):
        grasps_from_array(np.array([[*row, 0.5]]))


def test_isaac_grasp_reads_quaternions_and_confidence(tmp_path):
    pytest.importorskip("yaml", reason="isaac_grasp files need PyYAML")
    text = (
        "format: isaac_grasp\nformat_version: 1.0\ngrasps:\n  grasp_0:\n    confidence: 0.7\n"
        "    position: [0.1, 0.0, 0.0]\n    orientation: {w: 1.0, xyz: [0.0, 0.0, 0.0]}\n"
    )
    (tmp_path / "g.yaml").write_text(text)
    grasps = read_grasps(tmp_path / "g.yaml")
    assert grasps.scores[0] == 0.7
    assert np.allclose(grasps.poses_tool_to_source[0][:3, 3], [0.1, 0.0, 0.1034])


def test_plain_poses_come_with_scores():
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
def test_wrong_shapes_units_and_frames_are_named(array, words):
    with pytest.raises(InvalidInput, match=words):
        grasps_from_array(array)


def test_files_that_are_no_grasps_are_refused(tmp_path):
    (tmp_path / "a.npy").write_bytes(b"nothing")
    with pytest.raises(InvalidInput, match="no file of grasps"):
        read_grasps(tmp_path / "a.npy")
    with pytest.raises(InvalidInput, match="cannot be read"):
        read_grasps(tmp_path / "missing.npy")


def test_an_array_takes_scores_and_widths_of_its_own():
    poses = np.tile(np.eye(4), (2, 1, 1))
    given = grasps_from_array(poses, scores=[0.4, 0.9], widths=[0.05, 0.06])
    assert given.scores.tolist() == [0.4, 0.9] and given.widths.tolist() == [0.05, 0.06]
    assert np.isnan(grasps_from_array(poses).widths).all()
    with pytest.raises(InvalidInput, match=r"widths of shape \(1,\)"):
        grasps_from_array(poses, widths=[0.05])
    scene = Scene({"cup": np.random.default_rng(0).random((50, 3)) * 0.1}, up=[0, 0, 1])
    with pytest.raises(InvalidInput, match="have their own"):
        rank_grasps(scene, given, scores=[0.4, 0.9])
