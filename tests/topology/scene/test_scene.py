"""Scene: what is refused, what is kept read-only, and which way is up."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

CUBE = np.array([[x, y, z] for x in (0.0, 0.1) for y in (0.0, 0.1) for z in (0.0, 0.1)])
FLAT = np.stack(
    [*np.meshgrid(np.linspace(-0.5, 0.5, 40), np.linspace(-0.5, 0.5, 40)), np.zeros((40, 40))], axis=-1
)
TABLE = FLAT.reshape(-1, 3)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (np.empty((0, 3)), "empty"),
        (np.zeros((5, 2)), r"shape \(5, 2\)"),
        (np.zeros(3), r"shape \(3,\)"),
        (np.array([[0, 0, 0], [0, np.nan, 0], [np.inf, 0, 0]]), "2 of 3 points"),
        (CUBE * 1000, "millimetres"),
        ([["a", "b", "c"]], "text"),
        ([[1, 2, 3], [1, 2]], "ragged"),
        (CUBE.astype(complex), "complex"),
    ],
)
def test_a_broken_cloud_is_refused_by_name(points, words):
    with pytest.raises(InvalidInput, match=words) as refusal:
        Scene({"table": TABLE, "mug": points})  # type: ignore[dict-item]
    assert "'mug'" in str(refusal.value)


def test_degenerate_clouds_are_clouds():
    scene = Scene({"point": np.zeros((1, 3)), "line": np.zeros((4, 3)), "plane": TABLE})
    assert scene.names == ("point", "line", "plane")


@pytest.mark.parametrize("name", ["", "  ", "a\nb", 3])
def test_a_name_is_one_line_of_text(name):
    with pytest.raises(InvalidInput, match=r"name|a key of clouds"):
        Scene({name: CUBE})  # type: ignore[dict-item]


def test_no_objects_are_no_scene():
    with pytest.raises(InvalidInput, match="no objects"):
        Scene({})


def test_an_unknown_fixed_name_is_refused_with_the_known_ones():
    with pytest.raises(UnknownObject, match=r"'desk'.*mug, table"):
        Scene({"table": TABLE, "mug": CUBE}, fixed=["desk"])


@pytest.mark.parametrize("up", [(0, 0, 0), (0, np.nan, 1), (0, 0), (np.inf, 0, 0), "abc"])
def test_up_is_a_finite_direction(up):
    with pytest.raises(InvalidInput, match="up"):
        Scene({"mug": CUBE}, up=up)  # type: ignore[arg-type]


def test_up_is_scaled_to_length_one_and_says_so():
    scene = Scene({"mug": CUBE}, up=(0, 0, 5))
    assert scene.up is not None
    assert np.allclose(scene.up, [0, 0, 1])
    assert any("length 5" in line for line in scene.assumptions)
    assert Scene({"mug": CUBE}, up=(0, 0, 1)).assumptions == ()


def test_nobody_can_write_into_a_scene():
    given = CUBE.copy()
    scene = Scene({"mug": given}, up=(0, 0, 1))
    given[0] = 7.0
    assert scene.clouds["mug"].max() < 1
    with pytest.raises(ValueError, match="read-only"):
        scene.clouds["mug"][0] = 0
    with pytest.raises(TypeError):
        scene.clouds["cup"] = CUBE  # type: ignore[index]
    with pytest.raises(AttributeError):
        scene.up = None  # type: ignore[misc]


def test_a_scene_travels_between_processes():
    scene = Scene({"table": TABLE, "mug": CUBE}, ["table"], (0, 0, 1), [[1, 1, 1]], assumptions=["so"])
    back = pickle.loads(pickle.dumps(scene))
    assert back.names == scene.names
    assert back.fixed == scene.fixed
    assert back.assumptions == scene.assumptions
    assert np.array_equal(back.clouds["mug"], CUBE)


def test_a_changed_scene_leaves_the_old_one_alone():
    mesh = Mesh(CUBE, np.array([[0, 1, 2]]))
    scene = Scene({"table": TABLE, "mug": CUBE}, ["table"], meshes={"mug": mesh})
    moved = scene.with_cloud("mug", CUBE + 1)
    assert moved.names == scene.names
    assert "mug" not in moved.meshes
    assert scene.clouds["mug"].max() < 1
    assert moved.clouds["table"] is scene.clouds["table"]
    assert scene.without("table").fixed == frozenset()
    assert scene.movable == ("mug",)
    with pytest.raises(UnknownObject):
        scene.without("cup")
    with pytest.raises(InvalidInput, match="no objects"):
        scene.without("table").without("mug")


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (np.diag([1.0, 1.0, -1.0, 1.0]), "mirrored"),
        (np.diag([2.0, 2.0, 2.0, 1.0]), "rigid"),
        (np.eye(3), "shape"),
        (np.full((4, 4), np.nan), "NaN"),
        (np.eye(4) + np.eye(4, k=-3), "0 0 0 1"),
    ],
)
def test_the_robot_base_is_a_rigid_pose(pose, words):
    with pytest.raises(InvalidInput, match=words):
        Scene({"mug": CUBE}, robot_base=pose)  # type: ignore[arg-type]


def test_mesh_faces_name_vertices():
    with pytest.raises(InvalidInput, match="vertex 8"):
        Mesh(CUBE, np.array([[0, 1, 8]]))


@given(st.integers(0, 2**32 - 1))
def test_up_follows_the_fixed_plane_under_any_rotation(seed):
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    clouds = {"table": TABLE @ rotation.T, "mug": CUBE @ rotation.T}
    scene = Scene(clouds, ["table"]).upright()
    assert scene.up is not None
    assert np.allclose(scene.up, rotation[:, 2], atol=1e-6)
    assert "'table'" in scene.assumptions[0]


def test_a_curved_fixed_object_says_nothing_about_up():
    ball = np.random.default_rng(0).normal(size=(500, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    assert Scene({"stone": ball, "mug": CUBE}, ["stone"]).upright().up is None


def test_stray_points_do_not_tilt_the_table():
    stray = np.random.default_rng(1).uniform(-0.5, 0.5, (400, 3))
    scene = Scene({"table": np.concatenate([TABLE, stray]), "mug": CUBE}, ["table"]).upright()
    assert scene.up is not None
    assert np.allclose(scene.up, [0, 0, 1], atol=0.01)


def test_views_of_one_object_are_one_cloud_and_a_speck_is_left_out():
    label = np.ones((20, 30), dtype=int)
    label[5:10, 5:10] = 2
    label[0, 0] = 3
    intrinsics = [[30, 0, 15], [0, 30, 10], [0, 0, 1]]
    names = {1: "table", 2: "mug", 3: "speck"}
    images = [DepthImage(np.ones((20, 30)), intrinsics, label, np.eye(4), names) for _ in range(2)]  # type: ignore[arg-type]
    scene = Scene.from_images(images, fixed=["table"], up=(0, -1, 0))
    assert scene.names == ("table", "mug")
    assert len(scene.clouds["mug"]) == 50
    assert scene.viewpoints.shape == (2, 3)
    assert any("speck" in line for line in scene.assumptions)


def test_one_thing_under_two_names_is_said_and_two_that_touch_are_not():
    rng = np.random.default_rng(0)
    sides = [
        np.insert(rng.uniform(0, 0.1, (300, 2)), axis, end, axis=1) for axis in range(3) for end in (0, 0.1)
    ]
    box = np.concatenate(sides)
    flat = rng.uniform(0, 0.6, (4000, 3)) * [1, 1, 0] - [0.25, 0.25, 0]
    lid = np.concatenate([box[box[:, 2] == 0.1] + np.array([0, 0, height]) for height in (0.0005, 0.002)])
    for twin in (box.copy(), box + rng.normal(0, 0.001, box.shape), box[box[:, 0] < 0.05]):
        (said,) = [
            note
            for note in Scene({"table": flat, "box": box, "twin": twin}, ["table"]).assumptions
            if "twin" in note
        ]
        assert said.endswith("one thing under two names? leave one out") and "'box'" in said
    for other in (lid, box + np.array([0.1, 0, 0]), 0.5 * box + np.array([0.02, 0.02, 0.002])):
        assert not Scene({"table": flat, "box": box, "other": other}, ["table"]).assumptions
