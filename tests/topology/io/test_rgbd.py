"""RGB-D frames as scenes: made ones, and the real ones where they are at hand."""

import re
from pathlib import Path

import numpy as np
import pytest
from run_lengths import lengths

from topple.topology import DepthImage, Scene, scene_from_coco, scene_from_rgbd
from topple.topology.base.errors import InvalidInput
from topple.topology.io import load_scene

DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "rgbd"
FRAMES = sorted(DATA.glob("*.npz"))

K = np.array([[60.0, 0, 40], [0, 60.0, 30], [0, 0, 1]])


def _frame(**changes: object) -> dict[str, object]:
    """A camera that looks straight down on a table 1 m below, with a box of 10 cm on it."""
    depth, label = np.ones((60, 80), dtype=np.float32), np.ones((60, 80), dtype=np.uint8)
    depth[20:30, 20:30], label[20:30, 20:30] = 0.9, 2
    frame: dict[str, object] = {"depth": depth, "K": K, "label": label}
    frame |= changes
    return {key: value for key, value in frame.items() if value is not None}


def _save(folder: Path, **changes: object) -> Path:
    path = folder / "frame.npz"
    np.savez(path, **_frame(**changes))  # type: ignore[arg-type]
    return path


def test_the_table_is_named_by_its_label_and_says_where_up_is(tmp_path):
    scene = load_scene(_save(tmp_path), fixed=["1"])
    assert scene.names == ("1", "2")
    assert scene.movable == ("2",)
    assert np.allclose(scene.up, [0, 0, -1], atol=1e-6)  # type: ignore[arg-type]
    assert scene.viewpoints.tolist() == [[0, 0, 0]]
    assert len(scene.images) == 1


def test_without_fixed_the_table_plane_finds_the_table(tmp_path):
    scene = load_scene(_save(tmp_path, table_plane=[0, 0, -1, 1]))
    assert scene.fixed == {"1"}
    assert scene.up.tolist() == [0, 0, -1]  # type: ignore[union-attr]


def test_a_plane_without_a_table_label_gets_the_table_that_was_measured(tmp_path):
    label = np.zeros((60, 80), dtype=int)
    label[20:30, 20:30] = 2
    labelled = load_scene(_save(tmp_path, table_plane=[0, 0, -1, 1]))
    scene = load_scene(_save(tmp_path, label=label, table_plane=[0, 0, -1, 1]))
    assert scene.names == ("2", "table")
    assert np.array_equal(scene.clouds["table"], labelled.clouds["1"])


def test_with_nothing_to_go_by_up_is_unknown(tmp_path):
    assert load_scene(_save(tmp_path)).up is None


@pytest.mark.parametrize("key", ["label", "segmap", "seg"])
def test_the_mask_has_three_names(tmp_path, key):
    frame = _frame()
    mask = frame.pop("label")
    np.savez(tmp_path / "frame.npz", **frame, **{key: mask})  # type: ignore[arg-type]
    assert load_scene(tmp_path / "frame.npz").names == ("1", "2")


def test_a_record_in_an_npy_is_a_frame(tmp_path):
    frame = {key: np.asarray(value) for key, value in _frame().items()}
    record = np.zeros((), dtype=[(key, value.dtype, value.shape) for key, value in frame.items()])
    for key, value in frame.items():
        record[key] = value
    np.save(tmp_path / "frame.npy", record)
    assert load_scene(tmp_path / "frame.npy").names == ("1", "2")
    np.save(tmp_path / "frame.npy", np.array([record, record]))
    with pytest.raises(InvalidInput, match="2 records"):
        load_scene(tmp_path / "frame.npy")
    np.save(tmp_path / "frame.npy", np.zeros((5, 3)))
    with pytest.raises(InvalidInput, match="one array"):
        load_scene(tmp_path / "frame.npy")


def test_a_camera_pose_puts_the_scene_into_the_world(tmp_path):
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 1.0
    scene = load_scene(_save(tmp_path, pose_camera_to_world=pose), fixed=["1"])
    assert np.allclose(scene.clouds["1"][:, 2], 0, atol=1e-6)
    assert np.allclose(scene.up, [0, 0, 1], atol=1e-6)  # type: ignore[arg-type]
    assert scene.viewpoints.tolist() == [[0, 0, 1]]


def _changed(array: object, rows: slice, value: float) -> np.ndarray:
    changed = np.array(array, dtype=float)
    changed[rows, 20:30] = value
    return changed


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"depth": np.ones((60, 79))}, "one label per depth pixel"),
        ({"K": np.eye(3)}, "K is no intrinsic matrix"),
        ({"K": K.T}, "K is no intrinsic matrix"),
        ({"K": None}, "no K"),
        ({"label": None}, "no label"),
        ({"depth": None}, "no depth"),
        ({"label": np.zeros((60, 80), dtype=int)}, "label is 0 everywhere"),
        ({"label": np.full((60, 80), 0.5)}, "whole numbers"),
        ({"depth": np.full((60, 80), 900, dtype=np.uint16)}, "depth.*millimetres.*divide by 1000"),
        ({"pose_camera_to_world": np.diag([1, 1, -1, 1])}, "pose_camera_to_world.*mirrored.*turn"),
        ({"depth": _changed(np.ones((60, 80)), slice(20, 30), 0)}, "object '2' has 100 pixels"),
        ({"depth": _changed(np.ones((60, 80)), slice(20, 30), np.nan)}, "object '2' has 100 pixels"),
        ({"depth": np.ones((60, 80, 3))}, "depth has shape"),
        ({"rgb": np.zeros((60, 80), dtype=np.uint8)}, "rgb has shape"),
        ({"table_plane": [0, 0, 0, 0]}, "table_plane"),
    ],
)
def test_bad_frames_are_refused(tmp_path, changes, words):
    path = _save(tmp_path, **changes)
    with pytest.raises(InvalidInput, match=words) as refusal:
        load_scene(path)
    assert str(refusal.value).startswith(str(path))


def test_an_object_of_one_pixel_is_named(tmp_path):
    label = np.ones((60, 80), dtype=int)
    label[5, 5] = 7
    with pytest.raises(InvalidInput, match="'7' has 1 pixel in its mask and depth of its own in 1 of them"):
        load_scene(_save(tmp_path, label=label))


@pytest.mark.parametrize("seen", [0, 1, 3])
def test_an_object_that_depth_hardly_shows_is_refused_by_every_reader_alike(tmp_path, seen):
    frame = _frame()
    depth, label = np.array(frame["depth"]), np.array(frame["label"])
    label[35:47, 40:52] = 7
    depth[label == 7] = 0.0
    depth[40, 42 : 42 + seen] = 0.8
    words = f"'7' has 144 pixels in its mask and depth of its own in {seen or 'none'} of them, too few for a"
    stack = np.stack([label == number for number in (1, 2, 7)])
    runs = [
        {"segmentation": {"size": [60, 80], "counts": lengths(mask)}, "name": n}
        for mask, n in zip(stack, "127", strict=True)
    ]
    for read in (
        lambda: load_scene(_save(tmp_path, depth=depth, label=label)),
        lambda: scene_from_rgbd(depth, K, stack, ["1", "2", "7"]),
        lambda: scene_from_coco(depth, K, runs),
        lambda: Scene.from_images([DepthImage(depth, K, label)]),
    ):
        with pytest.raises(InvalidInput, match=words):
            read()


def test_masks_are_taken_in_memory_as_in_a_file(tmp_path):
    frame = _frame()
    depth, label = np.array(frame["depth"]), np.array(frame["label"])
    board, box = label > 0, label == 2
    board[:, 70:] = box[:, 70:] = False
    label[:, 70:] = 0
    stack = np.stack([board, box])  # the box lies on the board: its pixels are in both
    said = "masks of 'board', 'box' overlap: of two the smaller one has the pixels"
    made = [
        load_scene(_save(tmp_path, label=None, masks=stack, names=["board", "box"]), fixed=["board"]),
        load_scene(
            _save(tmp_path, label=None, masks=255 * stack[:, None].astype(np.uint8), names=["board", "box"]),
            fixed=["board"],
        ),
        scene_from_rgbd(depth, K, stack, ["board", "box"], fixed="board"),
        scene_from_rgbd(depth, K, {"board": board, "box": box}, fixed=["board"]),
    ]
    labels = scene_from_rgbd(depth, K, np.where(box, 2, label), {1: "board", 2: "box"}, fixed=["board"])
    for scene in made:
        assert scene.names == ("board", "box") and said in scene.assumptions
        assert scene.clouds["box"] == pytest.approx(labels.clouds["box"])
    table = scene_from_rgbd(depth, K, box[None], ["box"], pose_camera_to_world=np.diag([1.0, -1, -1, 1]))
    assert table.names == ("box", "table") and table.fixed == {"table"}
    assert table.up == pytest.approx([0, 0, 1], abs=1e-6)


@pytest.mark.parametrize(
    ("masks", "words"),
    [
        (np.zeros((2, 60, 80), bool), "masks of 1, 2 are empty, or all within smaller ones"),
        (np.full((2, 60, 80), 7.5), "expected true or false per object and pixel"),
        ([np.ones((60, 80)), np.ones((5, 80))], "masks is ragged"),
        ({"a": np.ones((50, 80))}, "one label per depth pixel"),
        (np.zeros((0, 60, 80)), "expected true or false per object and pixel"),
    ],
)
def test_masks_that_are_none_are_refused(masks, words):
    with pytest.raises(InvalidInput, match=words):
        scene_from_rgbd(np.array(_frame()["depth"]), K, masks)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("centre", "words"),
    [
        ((80.0, 60.0), "is K of a picture of 161 x 121[?] scale it; or is this a crop"),
        ((20.0, 15.0), "is K of a picture of 41 x 31[?]"),
        ((30.0, 40.0), "are cx and cy swapped[?]"),
    ],
)
def test_a_centre_far_from_the_middle_is_said(tmp_path, centre, words):
    other = K.copy()
    other[:2, 2] = centre
    notes = load_scene(_save(tmp_path, K=other)).assumptions
    assert any(
        re.search(rf"K's centre .{centre[0]:g}, {centre[1]:g}. is far .*: {words}", note) for note in notes
    )
    assert not any("K's centre" in note for note in load_scene(_save(tmp_path)).assumptions)


def _slanted(noise: float = 0.0) -> np.ndarray:
    """Depth (60, 80) of a table on which a camera looks down from the side [m], and the box of the frame."""
    rows = np.indices((60, 80))[0]
    depth = 0.45 / (0.6 + 0.4 * (rows - 30) / 60) + np.random.default_rng(0).normal(0, noise, (60, 80))
    depth[20:30, 20:30] -= 0.08
    return depth


@pytest.mark.parametrize(("near", "far"), [(0.1, 5.0), (0.02, 10.0)])
def test_a_raw_z_buffer_is_refused_and_close_depth_is_not(tmp_path, near, far):
    depth = _slanted()
    assert depth.max() < 1.2
    raw = (1 / near - 1 / depth) / (1 / near - 1 / far)
    for wrong in (raw, 1.0 - raw):
        with pytest.raises(InvalidInput, match="depth looks like a raw z-buffer"):
            load_scene(_save(tmp_path, depth=wrong))
    for right in (0.7 * depth, 0.7 * _slanted(0.001), _frame()["depth"]):
        assert len(load_scene(_save(tmp_path, depth=right)).names) == 2


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1e3, "it looks like millimetres; topple takes metres, so divide by 1000$"),
        (1e4, "it looks like tenths of a millimetre; topple takes metres, so divide by 10000$"),
        (1e2, "it looks like centimetres; topple takes metres, so divide by 100$"),
    ],
)
def test_depth_in_another_unit_is_told_by_how_far_the_scene_would_be(tmp_path, factor, words):
    with pytest.raises(InvalidInput, match=words):
        load_scene(_save(tmp_path, depth=factor * _slanted()))


@pytest.mark.skipif(not FRAMES, reason=f"the real frames are not at {DATA.parent.name}/{DATA.name}")
def test_real_frames_give_every_label_a_cloud_and_up_from_the_plane():
    planes = 0
    for path in FRAMES[::6]:
        with np.load(path) as arrays:
            labels = {str(label) for label in np.unique(arrays["label"]) if label}
            plane = arrays["table_plane"] if "table_plane" in arrays.files else None
        scene = load_scene(path, fixed=["1"] if plane is not None else [])
        assert set(scene.names) == labels
        if plane is None:
            assert scene.up is None
            continue
        assert np.allclose(scene.up, plane[:3], atol=1e-3)  # type: ignore[arg-type]
        heights = {name: np.median(cloud @ plane[:3] + plane[3]) for name, cloud in scene.clouds.items()}
        assert abs(heights["1"]) < 0.01
        assert min(heights.values()) > -0.02
        planes += 1
    assert planes > 0


@pytest.mark.skipif(not FRAMES, reason=f"the real frames are not at {DATA.parent.name}/{DATA.name}")
def test_the_fitted_plane_of_a_real_table_agrees_with_the_given_one():
    for path in FRAMES[:60:12]:
        with np.load(path) as arrays:
            frame = {key: arrays[key] for key in ("depth", "K", "label")}
            given = arrays["table_plane"][:3]
        from topple.topology.scene.scene import Scene
        from topple.topology.views.image import DepthImage

        scene = Scene.from_images([DepthImage(**frame)], fixed=["1"])
        assert scene.up is not None
        assert float(scene.up @ given) > np.cos(np.radians(1.5))
