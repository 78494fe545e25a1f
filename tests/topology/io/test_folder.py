"""A folder of clouds and meshes as a scene."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from topple.topology.base.errors import InvalidInput
from topple.topology.io import load_scene

POINTS = np.round(np.random.default_rng(3).uniform(0, 0.2, (60, 3)), 6).astype(np.float32)
CORNERS = np.array([[x, y, z] for x in (0.0, 0.1) for y in (0.0, 0.2) for z in (0.0, 0.3)])


def _box(path: Path) -> None:
    trimesh.creation.box(bounds=[[0, 0, 0], [0.1, 0.2, 0.3]]).export(path)


def _pcd(path: Path, storage: str, fields: str = "x y z rgb", points: np.ndarray = POINTS) -> None:
    width = len(fields.split())
    table = np.zeros((len(points), width), dtype="<f4")
    table[:, [fields.split().index(axis) for axis in "xyz"]] = points
    header = (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {'4 ' * width}\nTYPE {'F ' * width}\n"
        f"COUNT {'1 ' * width}\nWIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
        f"POINTS {len(points)}\nDATA {storage}\n"
    ).encode()
    if storage == "ascii":
        body = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in table).encode() + b"\n"
    elif storage == "binary":
        body = table.tobytes()
    else:
        flat = table.T.tobytes()
        packed = _literals_and_references(flat)
        body = struct.pack("<II", len(packed), len(flat)) + packed
    path.write_bytes(header + body)


def _literals_and_references(data: bytes) -> bytes:
    """Compress with LZF: runs of zeros as references to the zero before, the rest as literals."""
    packed = bytearray()
    position = 0
    while position < len(data):
        run = 0
        while (
            position > 0
            and run < 264
            and data[position + run : position + run + 1] == data[position - 1 : position]
        ):
            run += 1
        if run >= 3:
            length = run - 2
            packed += bytes([length << 5, 0]) if length < 7 else bytes([7 << 5, length - 7, 0])
            position += run
        else:
            packed += bytes([0, data[position]])
            position += 1
    return bytes(packed)


@pytest.mark.parametrize("storage", ["ascii", "binary", "binary_compressed"])
def test_pcd_clouds_are_read_in_every_storage(tmp_path, storage):
    _pcd(tmp_path / "mug.pcd", storage)
    assert np.allclose(load_scene(tmp_path).clouds["mug"], POINTS, atol=1e-6)


def test_pcd_fields_may_come_in_any_order_with_padding(tmp_path):
    _pcd(tmp_path / "mug.pcd", "binary", "_ z _ y x")
    assert np.allclose(load_scene(tmp_path).clouds["mug"], POINTS, atol=1e-6)


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_ply_clouds_and_xyz_text_are_read(tmp_path, encoding):
    cloud = trimesh.PointCloud(POINTS)
    (tmp_path / "mug.ply").write_bytes(cloud.export(file_type="ply", encoding=encoding))  # type: ignore[arg-type]
    lines = ["# x y z r g b", *(f"{x}, {y}, {z}, 255" for x, y, z in POINTS), ""]
    (tmp_path / "cup.xyz").write_text("\n".join(lines))
    (tmp_path / "notes.txt").write_text("not a cloud")
    scene = load_scene(tmp_path)
    assert scene.names == ("cup", "mug")
    assert np.allclose(scene.clouds["mug"], POINTS, atol=1e-6)
    assert np.allclose(scene.clouds["cup"], POINTS, atol=1e-6)
    assert not scene.meshes


CAMERA = ["element camera 1", "property float view_px", "property int viewportx"]
OTHERS = {
    "an empty face and a camera": (["element face 0", *CAMERA], struct.pack("<fi", 1.0, 640), "1 640\n"),
    "an empty face with its list": (["element face 0", "property list uchar int vertex_indices"], b"", ""),
    "a camera that says nothing": (["element camera 1"], b"", "\n"),
    "lists of other lengths": (
        ["element range_grid 2", "property list uchar int vertex_indices"],
        struct.pack("<BBi", 0, 1, 4),
        "0\n1 4\n",
    ),
}


@pytest.mark.parametrize("others", OTHERS)
@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_elements_of_a_ply_that_hold_nothing_are_passed_over(tmp_path, encoding, others):
    lines, binary, text = OTHERS[others]
    vertex = ["element vertex 60", *(f"property float {axis}" for axis in "xyz")]
    header = ["ply", "comment made", f"format {encoding} 1.0", *vertex, *lines, "end_header", ""]
    rows = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in POINTS)
    body = (rows + text).encode() if encoding == "ascii" else POINTS.astype("<f4").tobytes() + binary
    (tmp_path / "mug.ply").write_bytes("\n".join(header).encode() + body)
    assert np.allclose(load_scene(tmp_path).clouds["mug"], POINTS, atol=1e-6)


@pytest.mark.parametrize("last", ["end solid", "END SOLID part", "endsolid"])
def test_an_stl_text_may_end_in_two_words_and_be_called_anything(tmp_path, last):
    _box(tmp_path / "box.stl")
    text = trimesh.load(tmp_path / "box.stl").export(file_type="stl_ascii")
    lines = str(text).strip().splitlines()
    (tmp_path / "box.stl").write_text("\n".join(["solid vertex of a solid", *lines[1:-1], last]))
    assert len(load_scene(tmp_path).meshes["box"].faces) == 12
    (tmp_path / "box.stl").write_text("\n".join(lines[:-1]))
    with pytest.raises(InvalidInput, match="is an STL text without the line 'endsolid': it is cut short"):
        load_scene(tmp_path)


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply", "glb"])
def test_meshes_are_sampled_all_over_their_surface(tmp_path, suffix):
    _box(tmp_path / f"box.{suffix}")
    scene = load_scene(tmp_path)
    cloud = scene.clouds["box"]
    assert np.allclose(cloud.min(axis=0), 0, atol=1e-6)
    assert np.allclose(cloud.max(axis=0), [0.1, 0.2, 0.3], atol=1e-6)
    on_face = np.isclose(cloud, 0, atol=1e-6) | np.isclose(cloud, [0.1, 0.2, 0.3], atol=1e-6)
    assert on_face.any(axis=1).all()
    share = (np.isclose(cloud[:, 0], 0, atol=1e-6)).mean()
    assert share == pytest.approx(0.06 / 0.22, abs=0.01)  # that face's part of the box's surface
    assert len(scene.meshes["box"].faces) == 12
    assert np.array_equal(load_scene(tmp_path).clouds["box"], cloud)


def test_poses_and_files_place_one_mesh_twice(tmp_path):
    _box(tmp_path / "box.obj")
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    pose[:3, 3] = [1, 0, 0]
    described = {
        "files": {"left": "box.obj", "right": "box.obj"},
        "poses": {"right": pose.tolist()},
        "up": [0, 0, 1],
        "fixed": ["left"],
        "viewpoints": [[0, 0, 1]],
        "colour": "red",
    }
    (tmp_path / "scene.json").write_text(json.dumps(described))
    scene = load_scene(tmp_path)
    assert scene.names == ("left", "right")
    assert scene.fixed == {"left"}
    assert np.allclose(scene.clouds["right"].min(axis=0), [0.8, 0, 0], atol=1e-6)
    assert np.allclose(scene.meshes["right"].vertices.max(axis=0), [1, 0.1, 0.3], atol=1e-6)
    assert any("'colour'" in line for line in scene.assumptions)


POSED = '{"poses": {"box": %s}}'


@pytest.mark.parametrize(
    ("described", "words"),
    [
        ("{", "not JSON"),
        ("[1]", "expected an object"),
        ('{"up": [0, 0, 1], "up": [0, 1, 0]}', "'up' twice"),
        (POSED % np.diag([1, 1, -1, 1]).tolist(), "'box' in scene.json.*mirrored.*turn"),
        (POSED % np.diag([2, 2, 2, 1]).tolist(), "'box' in scene.json.*not rigid.*scale"),
        (POSED % np.eye(4, dtype=int)[::-1].tolist(), "'box' in scene.json.*row .1 0 0 0.*transpose"),
        (json.dumps({"robot_base": np.diag([-1, 1, 1, 1]).tolist()}), "robot_base.*mirrored.*turn"),
        ('{"poses": {"box": [1, 2]}}', "'box'.*shape"),
        ('{"poses": {"cup": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}', "a pose of 'cup'"),
        ('{"poses": [1]}', "poses holds list"),
        ('{"files": {"cup": "cup.obj"}}', "'cup', and it does not exist"),
        ('{"files": {"cup": "scene.json"}}', "expected .ply"),
        ('{"files": {"cup": 3}}', "expected a file name"),
        ('{"fixed": [3]}', "expected a list of names"),
        ('{"fixed": ["desk"]}', "unknown fixed object 'desk'"),
        ('{"up": "z"}', "up holds text"),
        ('{"viewpoints": [[0, 0], [1]]}', "viewpoints is ragged"),
    ],
)
def test_a_bad_scene_json_is_refused(tmp_path, described, words):
    _box(tmp_path / "box.obj")
    (tmp_path / "scene.json").write_text(described)
    with pytest.raises(InvalidInput, match=words):
        load_scene(tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("mug.ply", b"", "empty file"),
        ("mug.ply", b"this is no ply", "no readable PLY"),
        ("mug.obj", b"\x00\x01\x02", "'mug'"),
        ("mug.stl", b"solid nothing\nendsolid\n", "'mug'"),
        ("mug.glb", b"glTFxx", "no readable GLB"),
        ("mug.pcd", b"VERSION 0.7\nFIELDS x y z\n", "no DATA line"),
        (
            "mug.pcd",
            b"FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2\n",
            "fields are x y",
        ),
        ("mug.pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 9\nDATA binary\nabc", "no readable PCD"),
        ("mug.pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA ascii\n1 2 3\n", "3 numbers"),
        ("mug.pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA zip\n1 2 3\n", "DATA is 'zip'"),
        ("mug.pcd", b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\nnan 2 3\n", "NaN"),
        ("mug.xyz", b"0 0 0\n1 2 cup\n", "line 2"),
        ("mug.xyz", b"1 2\n", "line 1"),
        ("mug.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n f 1 3 2\n", "line 5: v or f alone"),
        ("mug.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf\xa01 2 3\n".encode("latin-1"), "line 4: v or f"),
        ("mug.xyz", b"\xff\xfe\x00", "no text"),
        ("mug.xyz", b"# nothing\n", "empty"),
        ("mug.xyz", b"0 0 0\n", "single point"),
        ("mug.xyz", b"0 0 0\n900 0 0\n", "millimetres"),
    ],
)
def test_a_broken_file_is_refused_by_name(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InvalidInput, match=words) as refusal:
        load_scene(tmp_path)
    assert "'mug'" in str(refusal.value)


def test_two_files_of_one_name_and_an_empty_folder_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match="no clouds or meshes"):
        load_scene(tmp_path)
    _box(tmp_path / "box.obj")
    _box(tmp_path / "box.stl")
    with pytest.raises(InvalidInput, match=r"box\.obj and box\.stl are both object 'box'"):
        load_scene(tmp_path)


def test_texts_may_begin_with_a_byte_order_mark(tmp_path):
    rows = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in POINTS)
    for name in ("mug.xyz", "cup.txt"):
        (tmp_path / name).write_text(rows, encoding="utf-8-sig")
    (tmp_path / "scene.json").write_text('{"up": [0, 0, 1]}', encoding="utf-8-sig")
    scene = load_scene(tmp_path)
    assert set(scene.names) == {"cup", "mug"} and scene.up is not None
    assert all(np.allclose(cloud, POINTS, atol=1e-6) for cloud in scene.clouds.values())
