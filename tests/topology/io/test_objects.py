"""Scenes of what other libraries hold in memory: one stack, told in each of their ways."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from run_lengths import lengths

from topple.planner.planning.order import order
from topple.topology import Scene, scene_from_coco, scene_from_objects, scene_from_points
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.io.coco import mask_of

SIZE = 0.1  # [m]


def block(z: float) -> trimesh.Trimesh:
    mesh = trimesh.creation.box((SIZE, SIZE, SIZE))
    mesh.apply_translation((0.0, 0.0, z))
    return mesh


def table() -> np.ndarray:
    x, y = np.meshgrid(np.arange(-0.3, 0.3, 0.01), np.arange(-0.3, 0.3, 0.01))
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])


def is_the_stack(scene: Scene) -> bool:
    """Whether it is a block on a block on a table."""
    if scene.names != ("table", "low", "top") or scene.fixed != {"table"}:
        return False
    ends = {name: (cloud.min(axis=0), cloud.max(axis=0)) for name, cloud in scene.clouds.items()}
    wanted = {name: ([-0.05, -0.05, z], [0.05, 0.05, z + SIZE]) for name, z in (("low", 0.0), ("top", SIZE))}
    placed = all(np.allclose(ends[name], wanted[name], rtol=0.0, atol=2e-3) for name in wanted)
    return placed and order(scene, "low").order == ("top", "low")


def records(points: np.ndarray, **more: np.ndarray) -> np.ndarray:
    """A structured array, as a PointCloud2 is read: floats of four bytes, colour beside the place."""
    kinds = [(axis, "<f4") for axis in "xyz"] + [("rgb", "<u4")]
    array = np.zeros(len(points), dtype=kinds + [(name, v.dtype) for name, v in more.items()])
    for axis, column in zip("xyz", points.T, strict=True):
        array[axis] = column
    for name, values in more.items():
        array[name] = values
    return array


@dataclass
class Stamped:
    """What a PoseStamped of any ROS is: nothing but its fields is asked for."""

    place: tuple[float, float, float]
    turn: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    frame: str = "world"
    header: SimpleNamespace = field(init=False)
    pose: SimpleNamespace = field(init=False)

    def __post_init__(self) -> None:
        self.header = SimpleNamespace(frame_id=self.frame)
        position = SimpleNamespace(**dict(zip("xyz", self.place, strict=True)))
        orientation = SimpleNamespace(**dict(zip("xyzw", self.turn, strict=True)))
        self.pose = SimpleNamespace(position=position, orientation=orientation)


def test_meshes_of_trimesh():
    scene = scene_from_objects({"table": table(), "low": block(0.05), "top": block(0.15)}, fixed=["table"])
    assert is_the_stack(scene)
    assert set(scene.meshes) == {"low", "top"} and scene.up == pytest.approx([0, 0, 1], abs=1e-3)


def test_clouds_and_scenes_of_trimesh():
    cloud = trimesh.PointCloud(trimesh.sample.sample_surface(block(0.05), 2000, seed=0)[0])
    parts = trimesh.Scene([block(0.15)])
    scene = scene_from_objects({"table": table(), "low": cloud, "top": parts}, fixed=["table"])
    assert set(scene.meshes) == {"top"}
    assert is_the_stack(scene)


def test_clouds_and_meshes_of_open3d():
    open3d = pytest.importorskip("open3d", reason="open3d is not installed: pip install open3d")
    flat = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(table()))
    low = open3d.geometry.TriangleMesh.create_box(SIZE, SIZE, SIZE).translate((-0.05, -0.05, 0.0))
    top = open3d.t.geometry.TriangleMesh.from_legacy(low).translate((0.0, 0.0, SIZE))
    assert is_the_stack(scene_from_objects({"table": flat, "low": low, "top": top}, fixed=["table"]))
    tensor = open3d.t.geometry.PointCloud.from_legacy(flat)
    assert is_the_stack(scene_from_objects({"table": tensor, "low": low, "top": top}, fixed=["table"]))


def test_records_of_a_point_cloud_with_returns_that_are_none():
    low, top = (trimesh.sample.sample_surface(block(z), 3000, seed=0)[0] for z in (0.05, 0.15))
    top = np.concatenate([top, [[np.nan, 0, 0]]])
    objects = {"table": records(table()), "low": records(low).reshape(2, -1), "top": records(top)}
    assert is_the_stack(scene_from_objects(objects, fixed=["table"]))


def test_poses_of_ros_place_models_in_their_own_frame():
    half = np.sqrt(0.5)  # a quarter turn leaves a cube what it is
    listed = [Stamped((0, 0, 0)), Stamped((0, 0, 0.05)), Stamped((0, 0, 0.15), (0, 0, half, half))]
    objects = {"table": table(), "low": block(0.0), "top": block(0.0)}
    assert is_the_stack(scene_from_objects(objects, listed, fixed=["table"]))
    lifted = np.eye(4)
    lifted[2, 3] = 0.15
    named = {"low": listed[1].pose, "top": lifted}  # a Pose without a stamp, and a matrix
    assert is_the_stack(scene_from_objects(objects, named, fixed=["table"]))
    base = Stamped((-0.5, 0, 0))
    scene = scene_from_objects(objects, listed, fixed=["table"], robot_base=base)
    assert scene.robot_base is not None and scene.robot_base[0, 3] == -0.5


@pytest.mark.parametrize("kind", ["u1", "f4"])
def test_one_cloud_with_a_label_field(kind):
    low, top = (trimesh.sample.sample_surface(block(z), 3000, seed=0)[0] for z in (0.05, 0.15))
    every = np.concatenate([table(), low, top])
    labels = np.repeat([1, 2, 3], [len(table()), len(low), len(top)]).astype(kind)
    names = {1: "table", 2: "low", 3: "top"}
    assert is_the_stack(scene_from_points(records(every, label=labels), names=names, fixed=["1"]))
    assert is_the_stack(scene_from_points(every, labels, names=names, fixed=["table"]))


def test_a_message_of_a_point_cloud():
    rosbags = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed: pip install '.[ros]'")
    types = rosbags.get_typestore(rosbags.Stores.ROS2_HUMBLE).types
    low, top = (trimesh.sample.sample_surface(block(z), 3000, seed=0)[0] for z in (0.05, 0.15))
    every = np.concatenate([table(), low, top])
    labels = np.repeat([1, 2, 3], [len(table()), len(low), len(top)]).astype("<u4")
    cloud = records(every, label=labels)
    numbers = {"<f4": 7, "<u4": 6}
    fields = [
        types["sensor_msgs/msg/PointField"](name, offset, numbers[kind.str], 1)
        for name, (kind, offset) in ((n, v[:2]) for n, v in cloud.dtype.fields.items())
    ]
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](0, 0), "camera")
    step, data = cloud.dtype.itemsize, np.frombuffer(cloud.tobytes(), np.uint8)
    message = types["sensor_msgs/msg/PointCloud2"](
        header, 1, len(cloud), fields, False, step, step * len(cloud), data, True
    )
    assert is_the_stack(scene_from_points(message, names={1: "table", 2: "low", 3: "top"}, fixed=["table"]))


@pytest.mark.parametrize(
    ("objects", "poses", "words"),
    [
        ({"a": object()}, (), "cloud 'a' is a object: expected points"),
        ({"a": trimesh.PointCloud(np.empty((0, 3)))}, (), "cloud 'a' is empty"),
        ({"a": np.zeros(3, dtype=[("x", "f4"), ("y", "f4")])}, (), "expected x, y and z"),
        ({"a": table()}, [np.eye(4), np.eye(4)], "2 poses for 1 objects"),
        ({"a": table()}, {"a": Stamped((0, 0, 0), (0, 0, 0, 0))}, "quaternion"),
        ({"a": table()}, {"b": np.eye(4)}, "unknown object with a pose 'b'"),
        (
            {"a": table(), "b": table()},
            [Stamped((0, 0, 0)), Stamped((0, 0, 0), frame="camera")],
            "different frames: pose of 'a' in world, pose of 'b' in camera",
        ),
    ],
)
def test_what_is_none_of_these_is_refused_by_name(objects, poses, words):
    with pytest.raises((InvalidInput, UnknownObject), match=words):
        scene_from_objects(objects, poses)


def test_a_cloud_without_labels_is_refused():
    with pytest.raises(InvalidInput, match="the cloud has no labels"):
        scene_from_points(records(table()))


K = np.array([[200.0, 0, 40], [0, 200.0, 30], [0, 0, 1]])
SHAPE = (60, 80)


def boxes() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Depth of a table a metre off with two things on it, and their masks."""
    depth, masks = np.full(SHAPE, 1.0), {}
    for name, part in (("left", np.s_[20:40, 10:30]), ("right", np.s_[20:40, 50:70])):
        masks[name] = np.zeros(SHAPE, dtype=bool)
        masks[name][part] = True
        depth[part] = 0.95
    return depth, masks


def test_run_lengths_and_polygons_are_the_masks_they_stand_for():
    _, masks = boxes()
    for mask in masks.values():
        assert (mask_of({"size": SHAPE, "counts": lengths(mask)}, SHAPE) == mask).all()
    assert (mask_of([[10, 20, 29, 20, 29, 39, 10, 39]], SHAPE) == masks["left"]).all()


def test_compressed_run_lengths_are_read_as_the_reference_writes_them():
    coco = pytest.importorskip("pycocotools.mask", reason="pycocotools is not installed")
    rng = np.random.default_rng(0)
    for share in (0.02, 0.5, 0.98):
        mask = rng.random((37, 53)) < share
        told = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
        assert (mask_of(told, mask.shape) == mask).all()
        assert (mask_of({**told, "counts": told["counts"].decode()}, mask.shape) == mask).all()


def test_compressed_run_lengths_of_a_known_mask():
    mask = np.zeros((9, 10), dtype=bool)  # of the reference's own tests
    mask[2:5, 3:7] = True
    assert (mask_of({"size": [9, 10], "counts": "m03600000i0"}, (9, 10)) == mask).all()


def test_masks_and_depth_become_a_scene():
    depth, masks = boxes()
    annotations = [
        {"category_id": 3, "segmentation": {"size": SHAPE, "counts": lengths(masks["left"])}},
        {"category_id": 3, "segmentation": [[50, 20, 69, 20, 69, 39, 50, 39]], "score": 0.9},
    ]
    scene = scene_from_coco(depth, K, annotations, [{"id": 3, "name": "cup"}], up=[0, 0, -1])
    assert set(scene.movable) == {"cup", "cup_2"} and scene.fixed == {"table"}
    assert scene.clouds["cup"][:, 0].max() < 0 < scene.clouds["cup_2"][:, 0].min()
    assert len(scene.clouds["cup"]) == masks["left"].sum() and len(scene.images) == 1


def test_of_two_masks_that_overlap_the_smaller_is_in_front():
    depth, masks = boxes()
    inner = np.zeros(SHAPE, dtype=bool)
    inner[25:30, 15:20] = True
    told = [
        {"name": n, "segmentation": {"size": SHAPE, "counts": lengths(m)}}
        for n, m in (("small", inner), ("large", masks["left"]))
    ]
    scene = scene_from_coco(depth, K, told, up=[0, 0, -1])
    assert len(scene.clouds["small"]) == 25 and len(scene.clouds["large"]) == 400 - 25


@pytest.mark.parametrize(
    ("segmentation", "words"),
    [
        (None, "annotation 0 has no segmentation"),
        ({"size": [1, 2], "counts": [2]}, "of the size"),
        ({"size": SHAPE, "counts": [5]}, "runs of 5 pixels together: expected 4800"),
        ({"size": SHAPE, "counts": "\x01"}, "expected run lengths"),
        ([[0, 0, 1]], "polygon of 3 numbers"),
    ],
)
def test_masks_that_are_none_are_refused(segmentation, words):
    with pytest.raises(InvalidInput, match=words):
        scene_from_coco(boxes()[0], K, [{"segmentation": segmentation}])


def test_one_name_alone_may_be_fixed():
    told = {"table": table(), "low": block(SIZE / 2), "top": block(1.5 * SIZE)}
    assert scene_from_objects(told, fixed="table", up=[0, 0, 1]).fixed == {"table"}
    labels = np.repeat([1, 2], [len(table()), 8])
    points = np.concatenate([table(), np.asarray(block(SIZE / 2).vertices)])
    assert scene_from_points(points, labels, names={1: "table"}, fixed="table").fixed == {"table"}


POLYGON = {"segmentation": [[2, 2, 8, 2, 8, 8]], "category_id": 1}


@pytest.mark.parametrize(
    ("annotations", "categories", "words"),
    [
        ({"annotations": [POLYGON]}, (), "annotations is of <class 'dict'>: expected Sequence"),
        ([5], (), r"annotations\[0\] is 5: expected Mapping"),
        ([{**POLYGON, "category_id": "x"}], (), "annotation 0: category_id"),
        ([POLYGON], [{"id": 1}], "categories: expected"),
        ([POLYGON], [5], r"categories\[0\] is 5: expected Mapping"),
        ([{"segmentation": [["a"] * 6]}], (), "annotation 0: its polygon holds text"),
        (
            [{"segmentation": {"size": [10, 10], "counts": [float("nan")]}}],
            (),
            "annotation 0 holds what is no",
        ),
        ([{"segmentation": {"size": "10", "counts": [100]}}], (), "annotation 0 is of the size 10"),
    ],
)
def test_what_is_not_of_coco_is_refused(annotations, categories, words):
    with pytest.raises(InvalidInput, match=words):
        scene_from_coco(np.ones((10, 10)), np.diag([50.0, 50.0, 1.0]), annotations, categories)  # type: ignore
