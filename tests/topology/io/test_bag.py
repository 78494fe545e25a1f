"""Recordings of ROS, written by rosbags itself."""

import io
import struct
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from topple.topology.base.errors import InvalidInput
from topple.topology.io import load_scene, load_sequence
from topple.topology.views.image import DepthImage

EXAMPLE = Path(__file__).parents[3] / "examples" / "03_write_bag.py"
UP, PIXELS, FOCAL = (0.0, 0.0, 1.0), (160, 120), 190.0
BASE = np.array([[0.0, -1, 0, -0.5], [1, 0, 0, 0.1], [0, 0, 1, 0], [0, 0, 0, 1]])
EYE = np.array([[0.0, -1, 0, 0.1], [-1, 0, 0, 0.2], [0, 0, -1, 0.8], [0, 0, 0, 1]])
"""A camera that looks straight down from 0.8 m."""


def _looks() -> list[DepthImage]:
    """Two pictures of two boxes (labels 2, 3) on a table (label 1); the higher one moves."""
    width, height = PIXELS
    K = np.array([[FOCAL, 0, (width - 1) / 2], [0, FOCAL, (height - 1) / 2], [0, 0, 1.0]])
    looks = []
    for shift in (0, 20):
        depth, label = np.full((height, width), 0.8), np.ones((height, width), np.int64)
        for number, left, top in ((2, 20, 0.7), (3, 80 + shift, 0.6)):
            depth[40:70, left : left + 25], label[40:70, left : left + 25] = top, number
        depth[0, :3] = 0.0
        looks.append(DepthImage(depth, K, label, EYE))
    return looks


@pytest.fixture(scope="module")
def example():
    spec = spec_from_file_location("write_bag", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def run(example: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a recording of two frames."""
    path = tmp_path_factory.mktemp("bags") / "run"
    example.write_bag(str(path), _looks(), BASE)
    return path


class _Own:
    """A recording of messages of its own."""

    def __init__(self, example: Any, path: Path) -> None:
        self.msg, self.path, self._example = example.MSG, path, example
        self._bag = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self._bag.open()

    def send(self, seconds: int, topic: str, message: Any) -> None:
        self._example._send(self._bag, seconds, topic, message)

    def frame(self, seconds: int, look: DepthImage, masks: int | None = None) -> Any:
        """Masks (taken at another second, perhaps) and intrinsics; gives the header of the depth."""
        height, width = look.depth.shape
        head, make = self._example._header(seconds, "camera_optical"), self.msg
        about = (np.zeros(5), look.K.ravel(), np.eye(3).ravel(), np.eye(3, 4).ravel(), 0, 0)
        info = make["sensor_msgs/CameraInfo"](head, height, width, "", *about, self._example.ROI)
        self.send(seconds, "/camera/camera_info", info)
        at = seconds if masks is None else masks
        taken = self._example._header(at, "camera_optical")
        self.send(seconds, "/mask", self._example._image(taken, look.label, "32SC1", "<i4"))
        return head

    def close(self) -> Path:
        self._bag.close()
        return self.path


@pytest.fixture
def own(example: Any, tmp_path: Path) -> _Own:
    return _Own(example, tmp_path / "own")


def _same(scene: Any, look: DepthImage, within: float = 5e-4) -> None:
    clouds = look.clouds()
    assert set(scene.names) == set(clouds)
    for name, cloud in clouds.items():
        assert scene.clouds[name] == pytest.approx(cloud, abs=within)


@pytest.mark.parametrize("form", ["folder", "file", "sqlite"])
def test_each_frame_stands_where_tf_says_the_camera_was(run, example, tmp_path, form):
    path = run if form == "folder" else run / "run.mcap"
    if form == "sqlite":
        example.write_bag(str(tmp_path / "run"), _looks(), BASE, StoragePlugin.SQLITE3)
        path = tmp_path / "run" / "run.db3"
    for number, look in enumerate(_looks()):
        scene = load_scene(path, image=number, fixed=["1"])
        _same(scene, look, 0.6e-3)
        assert scene.viewpoints == pytest.approx(EYE[None, :3, 3])
        assert scene.robot_base == pytest.approx(BASE) and scene.up == pytest.approx(UP)
        assert "up is z of the frame 'world', the root of tf" in scene.assumptions


def test_a_stream_is_followed_frame_by_frame(run):
    scenes = list(load_sequence(run, fixed=["1"], depth="/camera/depth/image_rect"))
    assert len(scenes) == 2
    for scene, look in zip(scenes, _looks(), strict=True):
        _same(scene, look, 0.6e-3)


def test_the_first_frame_is_taken_and_said(run):
    assert any("frame 0 of 2 is taken" in note for note in load_scene(run, fixed=["1"]).assumptions)
    with pytest.raises(InvalidInput, match="has 2 messages: there is no frame 2"):
        load_scene(run, image=2)


def _png(pixels: np.ndarray) -> np.ndarray:
    packed = io.BytesIO()
    Image.fromarray(pixels).save(packed, format="png")
    return np.frombuffer(packed.getvalue(), np.uint8)


@pytest.mark.parametrize("form", ["32FC1", "big-endian", "png", "compressedDepth", "compressed 32FC1"])
def test_depth_comes_in_every_usual_form(own, form):
    look = _looks()[0]
    head, make = own.frame(1, look), own.msg
    height, width = look.depth.shape
    if form == "32FC1":
        values = np.where(look.depth > 0, look.depth, np.nan).astype("<f4")
        message = make["sensor_msgs/Image"](
            head, height, width, form, 0, 4 * width, values.view("u1").ravel()
        )
    elif form == "big-endian":
        values = np.pad(np.round(1e3 * look.depth).astype(">u2"), ((0, 0), (0, 3)))  # and rows with a rest
        data = np.ascontiguousarray(values).view("u1").ravel()
        message = make["sensor_msgs/Image"](head, height, width, "16UC1", 1, 2 * (width + 3), data)
    elif form == "compressed 32FC1":
        scale, offset = 100.0, 3.0
        stored = np.where(look.depth > 0, scale / np.maximum(look.depth, 0.1) + offset, 0)
        head12 = np.frombuffer(struct.pack("<iff", 0, scale, offset), np.uint8)
        data = np.concatenate([head12, _png(np.round(stored).astype("u2"))])
        message = make["sensor_msgs/CompressedImage"](head, "32FC1; compressedDepth png", data)
    else:
        data, words = _png(np.round(1e3 * look.depth).astype("u2")), "16UC1; png"
        if form == "compressedDepth":
            data, words = np.concatenate([np.zeros(12, np.uint8), data]), "16UC1; compressedDepth png"
        message = make["sensor_msgs/CompressedImage"](head, words, data)
    own.send(1, "/camera/depth", message)
    scene = load_scene(own.close(), fixed=["1"], up=[0, 0, -1])
    within = 4e-3 if form == "compressed 32FC1" else 0.6e-3
    _same(scene, DepthImage(look.depth, look.K, look.label), within)  # no tf: the camera's frame
    assert scene.robot_base is None


@pytest.mark.parametrize("label", ["label", "instance"])
def test_a_cloud_with_a_label_per_point_is_a_scene(own, example, label):
    points = np.random.default_rng(0).uniform(0, 0.1, (40, 3)).astype("<f4")
    kind = np.dtype({"names": ["x", "y", "z", label], "formats": ["<f4", "<f4", "<f4", "<u4"],
                     "offsets": [0, 4, 8, 16], "itemsize": 24})  # fmt: skip
    rows = np.zeros(40, kind)
    for column, axis in enumerate("xyz"):
        rows[axis] = points[:, column]
    rows[label] = np.arange(40) // 10  # 0 is background
    field = own.msg["sensor_msgs/PointField"]
    fields = [field(axis, 4 * k, 7, 1) for k, axis in enumerate("xyz")] + [field(label, 16, 6, 1)]
    head = example._header(1, "camera_optical")
    own.send(1, "/tf", own.msg["tf2_msgs/TFMessage"]([example._transform("camera_optical", EYE)]))
    cloud = own.msg["sensor_msgs/PointCloud2"](
        head, 1, 40, fields, False, 24, 960, rows.view("u1").ravel(), True
    )
    own.send(1, "/points", cloud)
    scene = load_scene(own.close())
    assert scene.names == ("1", "2", "3")
    assert scene.clouds["2"] == pytest.approx(points[20:30] @ EYE[:3, :3].T + EYE[:3, 3], abs=1e-6)
    assert scene.up == pytest.approx(UP) and scene.viewpoints == pytest.approx(EYE[None, :3, 3])


def test_topics_that_are_not_plain_are_asked_for(own, run):
    look = _looks()[0]
    head = own.frame(1, look)
    for topic in ("/a/depth", "/b/depth"):
        own.send(1, topic, own._example._image(head, 1e3 * look.depth, "16UC1", "<u2"))
    path = own.close()
    with pytest.raises(
        InvalidInput, match=r"say with depth=TOPIC which .* is meant: it has .*/a/depth \(Image"
    ):
        load_scene(path)
    _same(load_scene(path, depth="/b/depth", fixed=["1"], up=UP), DepthImage(look.depth, look.K, look.label))
    wrong = pytest.raises(InvalidInput, match="masks=/camera/camera_info is no topic of Image or Compressed")
    with wrong, pytest.warns(DeprecationWarning, match="labels is now masks"):
        load_scene(path, depth="/b/depth", labels="/camera/camera_info")
    with pytest.raises(InvalidInput, match="info=/nothing is no topic of CameraInfo: it has "):
        load_scene(run, info="/nothing")


def test_masks_of_another_moment_and_intrinsics_of_another_camera_are_refused(own):
    look = _looks()[0]
    head = own.frame(5, look, masks=4)
    own.send(5, "/depth", own._example._image(head, 1e3 * look.depth, "16UC1", "<u2"))
    head = own._example._header(4, "camera_optical")
    small = own._example._image(head, 1e3 * look.depth[::2, ::2], "16UC1", "<u2")
    own.send(5, "/small/depth", small)
    path = own.close()
    with pytest.raises(InvalidInput, match=r"the closest labels of /mask are 1\.00 s away"):
        load_scene(path, depth="/depth")
    with pytest.raises(InvalidInput, match="expected the intrinsics of the depth camera"):
        load_scene(path, depth="/small/depth")


def test_tf_is_taken_as_it_was_when_the_picture_was_taken(own):
    looks = _looks()
    for at in (1, 3):
        moved = EYE.copy()
        moved[0, 3] += at
        tree = own._example._transform("camera_optical", moved)
        tree.header.stamp.sec = at
        own.send(at, "/tf", own.msg["tf2_msgs/TFMessage"]([tree]))
    for at in (2, 4):
        head = own.frame(at, looks[0])
        own.send(at, "/depth", own._example._image(head, 1e3 * looks[0].depth, "16UC1", "<u2"))
    path = own.close()
    seen = [load_scene(path, image=k, fixed=["1"]).viewpoints[0, 0] for k in (0, 1)]
    assert seen == pytest.approx([1.1, 3.1])


ASIDE = np.array([[1.0, 0, 0, 0.05], [0, 1, 0, 0.0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""Of a camera 5 cm to the right of the depth camera, in that one's frame."""


def _aside(own: _Own, tree: list[Any], frame: str = "colour_optical", info: bool = True) -> Path:
    """A recording whose labels another camera took; in its own picture things lie to the left."""
    look, make, example = _looks()[0], own.msg, own._example
    own.send(0, "/tf", make["tf2_msgs/TFMessage"](tree))
    head, taken = example._header(1, "camera_optical"), example._header(1, frame)
    (height, width), roi = look.depth.shape, example.ROI
    for topic, at in [("/camera/camera_info", head), *([("/colour/camera_info", taken)] if info else [])]:
        about = (np.zeros(5), look.K.ravel(), np.eye(3).ravel(), np.eye(3, 4).ravel(), 0, 0)
        own.send(1, topic, make["sensor_msgs/CameraInfo"](at, height, width, "", *about, roi))
    own.send(1, "/camera/depth", example._image(head, 1e3 * look.depth, "16UC1", "<u2"))
    label = np.ones(look.label.shape, np.int64)
    for number, top in ((2, 0.7), (3, 0.6)):
        rows, columns = np.nonzero(look.label == number)
        label[rows, columns - round(0.05 * FOCAL / top)] = number
    own.send(1, "/mask", example._image(taken, label, "32SC1", "<i4"))
    return own.close()


@pytest.mark.parametrize("info", [True, False])
def test_labels_of_another_camera_are_laid_onto_the_depth_by_tf(own, info):
    tree = [
        own._example._transform(*each) for each in (("camera_optical", EYE), ("colour_optical", EYE @ ASIDE))
    ]
    scene = load_scene(_aside(own, tree, info=info), info="/camera/camera_info", fixed=["1"])
    for name, cloud in _looks()[0].clouds().items():
        if name != "1":
            assert scene.clouds[name].mean(axis=0) == pytest.approx(cloud.mean(axis=0), abs=4e-3)
    said = "labels in the frame 'colour_optical' are laid by tf on depth in 'camera_optical'"
    (note,) = [note for note in scene.assumptions if note.startswith(said)]
    assert ("same intrinsics" in note) != info


def test_labels_of_a_frame_that_tf_does_not_know_are_refused_and_those_of_the_same_place_taken(
    own, example, tmp_path
):
    here = own._example._transform("camera_optical", EYE)
    words = "depth is in the frame 'camera_optical' and the labels in 'colour_optical': expected one frame"
    with pytest.raises(InvalidInput, match=words):
        load_scene(_aside(own, [here]), info="/camera/camera_info")
    other = _Own(example, tmp_path / "other")
    scene = load_scene(
        _aside(other, [here, own._example._transform("same", EYE)], "same", False), fixed=["1"]
    )
    assert not any("by tf on depth" in note for note in scene.assumptions)


def test_intrinsics_of_a_camera_elsewhere_are_refused(own):
    tree = [
        own._example._transform(*each) for each in (("camera_optical", EYE), ("colour_optical", EYE @ ASIDE))
    ]
    with pytest.raises(InvalidInput, match="and the camera_info in 'colour_optical': name that of the depth"):
        load_scene(_aside(own, tree), info="/colour/camera_info")


def test_what_is_no_pose_in_tf_is_left_out_and_said(own):
    bad = [own._example._transform(name, EYE) for name in ("marker", "far", "world")]
    bad[0].transform.rotation = own.msg["geometry_msgs/Quaternion"](0.0, 0.0, 0.0, 0.0)
    bad[1].transform.translation.x = np.nan
    tree = [*bad, own._example._transform("camera_optical", EYE)]
    scene = load_scene(_aside(own, tree, "camera_optical", False), fixed=["1"])
    assert scene.viewpoints == pytest.approx(EYE[None, :3, 3])
    for name in ("marker", "far", "world"):
        assert f"what tf says of {name!r} in 'world' is no pose: it is left out" in scene.assumptions


def test_a_circle_of_frames_is_refused(own):
    look = _looks()[0]
    tree = [own._example._transform("camera_optical", EYE), own._example._transform("world", EYE)]
    tree[1].header.frame_id = "camera_optical"
    own.send(1, "/tf", own.msg["tf2_msgs/TFMessage"](tree))
    head = own.frame(1, look)
    own.send(1, "/depth", own._example._image(head, 1e3 * look.depth, "16UC1", "<u2"))
    with pytest.raises(InvalidInput, match="tf goes round in a circle"):
        load_scene(own.close())


def test_recordings_of_ros_1_are_read(tmp_path):
    store, look = get_typestore(Stores.ROS1_NOETIC), _looks()[0]
    make, (height, width) = store.types, look.depth.shape
    head = make["std_msgs/msg/Header"](0, make["builtin_interfaces/msg/Time"](1, 0), "camera")
    zeros = make["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    about = (np.zeros(5), look.K.ravel(), np.eye(3).ravel(), np.eye(3, 4).ravel(), 0, 0, zeros)
    depth = np.round(1e3 * look.depth).astype("<u2")
    label = look.label.astype("u1")
    image = make["sensor_msgs/msg/Image"]
    messages = {
        "/cam/camera_info": make["sensor_msgs/msg/CameraInfo"](head, height, width, "", *about),
        "/cam/depth": image(head, height, width, "16UC1", 0, 2 * width, depth.view("u1").ravel()),
        "/labels": image(head, height, width, "8UC1", 0, width, label.ravel()),
    }
    with Writer1(tmp_path / "run.bag") as bag:
        for topic, message in messages.items():
            connection = bag.add_connection(topic, message.__msgtype__, typestore=store)
            bag.write(connection, 10**9, store.serialize_ros1(message, message.__msgtype__))
    scene = load_scene(tmp_path / "run.bag", fixed=["1"], up=UP)
    assert "1" in scene.fixed and len(scene.movable) > 1
    _same(scene, DepthImage(look.depth, look.K, look.label))


def test_broken_recordings_are_refused_in_a_line(run, tmp_path):
    data = (run / "run.mcap").read_bytes()
    for size in (16, 1000, len(data) // 2, len(data) - 30):
        (tmp_path / "cut.mcap").write_bytes(data[:size])
        with pytest.raises(InvalidInput, match=r"cut\.mcap: is no readable recording of ROS \("):
            load_scene(tmp_path / "cut.mcap")


def test_without_rosbags_its_extra_is_named(run, monkeypatch, typed):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    assert "recordings of ROS need rosbags: pip install 'rosbags>=0.11.9'" in typed("relate", run, code=2).err
