"""A GLB or OBJ file as a scene, a node or group an object."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import topple
from topple.topology import InvalidInput, load_scene

Z_TO_Y = trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0])


def at(x: float, y: float, z: float) -> np.ndarray:
    return trimesh.transformations.translation_matrix([x, y, z])


def glb(path: Path, wrapped: bool) -> Path:
    """A table, a mug with its handle below it, turned and scaled, and a mug beside the table."""
    made = trimesh.Scene()
    parent = "room" if wrapped else None
    if wrapped:
        made.graph.update(frame_to="room", matrix=Z_TO_Y)
    turn = np.eye(4) if wrapped else Z_TO_Y
    for name, size, place in (
        ("table", (1, 1, 0.04), at(0, 0, -0.02)),
        ("mug", (0.04, 0.04, 0.05), at(0.3, 0, 0.05) @ np.diag([2, 2, 2, 1])),
        ("astray", (0.08, 0.08, 0.1), at(0.9, 0, 0.05)),
    ):
        made.add_geometry(
            trimesh.creation.box(size), node_name=name, parent_node_name=parent, transform=turn @ place
        )
    handle = trimesh.creation.box((0.01, 0.005, 0.03))
    made.add_geometry(handle, node_name="handle", parent_node_name="mug", transform=at(0.025, 0, 0))
    made.export(path)
    return path


@pytest.mark.parametrize("wrapped", [False, True])
def test_nodes_of_a_glb_are_objects_with_all_that_hangs_on_them_and_y_is_up(wrapped, tmp_path):
    scene = load_scene(glb(tmp_path / "room.glb", wrapped))
    assert set(scene.names) == {"table", "mug", "astray"}
    assert scene.fixed == {"table"}
    assert scene.up is not None
    assert np.allclose(scene.up, [0, 1, 0])
    mug = scene.meshes["mug"].vertices
    assert np.allclose([mug.min(axis=0), mug.max(axis=0)], [[0.26, 0, -0.04], [0.36, 0.1, 0.04]], atol=1e-6)
    assert topple.check(scene).sentence() == "1 of 2 stand; astray floats above nothing"


def test_objects_of_an_obj_are_its_objects_or_else_its_groups(tmp_path):
    corners = trimesh.creation.box((0.1, 0.1, 0.1))
    lines: list[str] = []
    for letter, name, height in (("{0}", "low", 0.05), ("{0}", "high", 0.15), ("g", "part", 0.25)):
        lines.append(f"{letter} {name}")
        lines += [("v" + 3 * " {:.3f}").format(*np.add(each, [0, 0, height])) for each in corners.vertices]
        lines += ["f {} {} {}".format(*face) for face in (corners.faces - 8).tolist()]  # from the last
    text = "\n".join(lines) + "\n"
    (tmp_path / "a.obj").write_text(text.format("o"))
    assert set(load_scene(tmp_path / "a.obj", up=(0, 0, 1)).names) == {"low", "high"}
    (tmp_path / "b.obj").write_text(text.format("g"))
    scene = load_scene(tmp_path / "b.obj", up=(0, 0, 1), fixed=["low"])
    assert set(scene.names) == {"low", "high", "part"}
    assert scene.meshes["part"].vertices[:, 2].max() == pytest.approx(0.3)
    assert topple.check(scene).stands


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.glb", b"glTF nothing", "no readable GLB"),
        ("a.obj", b"o mug\nv 0 0 0\n", "holds no mesh"),
        ("a.obj", b"o mug\nv 0 0 0\nv 1 0 0\nf 1 2 3\n", "line 4 names a vertex that is not there"),
        ("a.obj", b"o mug\nv 0 0\n", "expected three numbers"),
    ],
)
def test_a_broken_file_is_refused_in_one_line(name, content, says, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InvalidInput, match=says):
        load_scene(tmp_path / name)


def test_nodes_that_go_round_in_circles_come_to_an_end(tmp_path):
    made = trimesh.Scene()
    made.add_geometry(trimesh.creation.box((1, 1, 1)), node_name="a", transform=np.eye(4))
    data = made.export(file_type="glb")
    (tmp_path / "a.glb").write_bytes(data.replace(b'"children":[1]', b'"children":[0]'))
    try:
        scene = load_scene(tmp_path / "a.glb")
    except InvalidInput:
        return
    assert len(scene.names) == 1
