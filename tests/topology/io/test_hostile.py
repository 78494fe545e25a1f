"""Files that would crash a reader, exhaust the memory or be misread are refused in one line."""

import io
import json
import os
import sys
import time
import tracemalloc
import zipfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from topple.topology import InvalidInput, load_scene, load_sequence

CLOUD = np.random.default_rng(0).uniform(0.0, 0.05, (300, 3))
AWAY = np.eye(4)
AWAY[0, 3] = 1e308
ROWS = "0 0 0\n0.1 0 0\n0 0.1 0\n"
POSTSCRIPT = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 5 4\n%%EndComments\nshowpage\n"
PCD = (
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT {count}\nWIDTH 2\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
)


def npy(points: np.ndarray = CLOUD) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, points)
    return buffer.getvalue()


def zipped(path: Path, member: bytes, compression: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr("a.npy", member)
    return path


def folder(path: Path, files: dict[str, str | bytes]) -> Path:
    path.mkdir()
    for name, content in files.items():
        place = path / name
        place.parent.mkdir(exist_ok=True)
        place.write_bytes(content) if isinstance(content, bytes) else place.write_text(content)
    return path


def named(at: Path, file: str) -> Path:
    return folder(at / "f", {"a.xyz": ROWS, "scene.json": json.dumps({"files": {"a": file}})})


def put(at: Path, name: str, make: Callable[[Path], None]) -> Path:
    """A folder of one cloud and something that is made there."""
    scene = at / "f"
    if not scene.is_dir():
        folder(scene, {"a.xyz": ROWS})
    make(scene / name)
    return scene


def linked(place: Path) -> None:
    """A link to a file beside the folder."""
    outside = place.parents[1] / f"secret{place.suffix}"
    outside.write_text("secret\n1 2 3\n")
    place.symlink_to(outside)


def filed(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def corrupt(path: Path) -> Path:
    zipped(path, npy(), zipfile.ZIP_LZMA)
    content = bytearray(path.read_bytes())
    content[60] ^= 255
    content[80] ^= 255
    path.write_bytes(content)
    return path


def ply(declared: int, given: int) -> str:
    rows = "".join(f"0.1 {0.1 * row:.2f} 0.3\n" for row in range(given))
    properties = "property float x\nproperty float y\nproperty float z\n"
    return f"ply\nformat ascii 1.0\nelement vertex {declared}\n{properties}end_header\n{rows}"


def huge(path: Path) -> Path:
    """A header that declares three gigabytes, and nothing behind it."""
    buffer = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": (130_000_000, 3)}
    np.lib.format.write_array_header_1_0(buffer, header)
    return zipped(path, buffer.getvalue())


def bomb(path: Path) -> Path:
    """Zeros that deflate to a thousandth."""
    return zipped(path, npy(np.zeros((24_000_000, 3))))


def saved(path: Path, **arrays: object) -> Path:
    np.savez(path, **arrays)  # type: ignore[arg-type]
    return path


HOSTILE: dict[str, tuple[Callable[[Path], Path], str]] = {
    "a header that does not end": (
        lambda at: zipped(at / "a.npz", npy().replace(b"}", b"(", 1)), "'a' is broken"
    ),
    "corrupt compression": (lambda at: corrupt(at / "a.npz"), "broken"),
    "a declared size that is not there": (lambda at: huge(at / "a.npz"), "3120 MB.*max_bytes=N"),
    "a bomb": (lambda at: bomb(at / "a.npz"), "576 MB.*max_bytes=N"),
    "json of a hundred thousand brackets": (
        lambda at: folder(at / "f", {"a.npy": npy(), "scene.json": "[" * 100_000 + "]" * 100_000}),
        "nested too deeply",
    ),
    "a number of five thousand digits": (
        lambda at: folder(at / "f", {"a.xyz": "0 0 0\n", "scene.json": '{"up": [0, 0, ' + "9" * 5000 + "]}"}),
        "scene.json is not JSON",
    ),
    "a far cloud": (lambda at: saved(at / "a.npz", a=CLOUD + 1e15), "1e\\+15, beyond 1e\\+08"),
    "an endless cloud": (lambda at: saved(at / "a.npz", a=CLOUD + 1e200), "beyond 1e\\+08"),
    "a plane of no size": (
        lambda at: saved(at / "a.npz", a=CLOUD, table_plane=[0, 0, 1e300, 1e300]), "table_plane.*beyond"
    ),
    "a pose out of this world": (
        lambda at: folder(
            at / "f",
            {
                "a.xyz": "0 0 0\n0.1 0 0\n",
                "scene.json": json.dumps({"poses": {"a": AWAY.tolist()}}),
            },
        ),
        "pose of 'a'.*beyond",
    ),
    "micrometres": (lambda at: saved(at / "a.npz", a=1e-6 * CLOUD), "too small; topple takes metres"),
    "a ply with fewer points than declared": (
        lambda at: folder(at / "f", {"a.ply": ply(100, 4)}), "declares 100 of vertex, and has 4 lines"
    ),
    "a ply with more points than declared": (
        lambda at: folder(at / "f", {"a.ply": ply(2, 4)}), "declares 2 of vertex, and has 4 lines"
    ),
    "a face of vertex 0": (
        lambda at: folder(at / "f", {"a.obj": "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 0 1 2\n"}),
        "vertex 0 in line 4",
    ),
    "a face cut short": (
        lambda at: folder(at / "f", {"a.obj": "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\nf 1 2 "}),
        "reads 'f 1 2' in line 5",
    ),
    "a vertex cut short": (
        lambda at: folder(at / "f", {"a.obj": "v 0 0 0\nv 0.1 0 0\nv 0 0.1\nf 1 2 3\n"}),
        "reads 'v 0 0.1' in line 3",
    ),
    "a face whose word runs into its number": (
        lambda at: folder(at / "f", {"a.obj": "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf1 2 3\n"}),
        "reads 'f1 2 3' in line 4",
    ),
    "several numbers for one axis": (
        lambda at: folder(at / "f", {"a.pcd": PCD.format(count="4 1 1", points=2, data="ascii") + "0 " * 12}),
        "its x has",
    ),
    "a stl that is neither kind": (
        lambda at: folder(at / "f", {"a.stl": b"solid x\nfacet normal 0 0 z\nouter loop\nvertex 0 0\n" * 9}),
        "without the line 'endsolid'",
    ),
    "names that are no text": (
        lambda at: saved(at / "a.npz", a=CLOUD, fixed=np.array([0x7FFFFFFF, 0], dtype="<u4").view("<U2")),
        "holds what is no text",
    ),
    "a label beyond all numbers": (
        lambda at: saved(
            at / "a.npz", depth=np.ones((4, 5)), K=[[5, 0, 2], [0, 5, 2], [0, 0, 1]],
            label=np.full((4, 5), 1 << 63, dtype=np.uint64),
        ),
        "holds the label 9223372036854775808",
    ),
    "a float label beyond all numbers": (
        lambda at: saved(
            at / "a.npz", depth=np.ones((4, 5)), K=[[5, 0, 2], [0, 5, 2], [0, 0, 1]],
            label=np.full((4, 5), 1e300),
        ),
        "expected whole numbers",
    ),
    "a label that is none": (
        lambda at: filed(
            at / "a.pcd",
            "VERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n"
            "DATA ascii\n0 0 0 1\n0 0 0.1 -1e300\n",
        ),
        "its label has numbers that are no uint32",
    ),
    "a label for every point": (
        lambda at: saved(at / "a.npz", points=np.tile(CLOUD, (67, 1)), labels=np.arange(20_100)),
        "20099 labels: expected one per object, at most 10000",
    ),
    "a cloud of small numbers that are held as large ones": (
        lambda at: saved(at / "a.npz", a=np.zeros((12_000_000, 3), dtype=np.int8)),
        "would unpack to 288 MB",
    ),
    "an OBJ of as many materials as faces": (
        lambda at: folder(
            at / "f",
            {"a.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"usemtl {k}\nf 1 2 3\n" for k in range(9999))},
        ),
        "more than 200 materials",
    ),
    "an STL of as many solids as faces": (
        lambda at: folder(
            at / "f",
            {
                "a.stl": "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                "endloop\nendfacet\nendsolid\n" * 9999
            },
        ),
        "more than 200 solids",
    ),
    "a negative number of points": (
        lambda at: folder(at / "f", {"a.pcd": PCD.format(count="1 1 1", points=-1, data="binary")}),
        "declares -1 points",
    ),
    "counts of nothing": (
        lambda at: folder(at / "f", {"a.pcd": PCD.format(count="1 1 0", points=2, data="ascii")}),
        "declares 2 points of 1 1 0",
    ),
    "counts left out": (
        lambda at: folder(at / "f", {"a.pcd": PCD.format(count="1 1", points=2, data="ascii")}),
        "3 fields, 3 types and 2 counts",
    ),
    "a billion points": (
        lambda at: folder(at / "f", {"a.pcd": PCD.format(count="1 1 1", points=10**9, data="binary")}),
        "12000 MB.*max_bytes=N",
    ),
    "compressed points that unpack to more": (
        lambda at: folder(
            at / "f",
            {
                "a.pcd": PCD.format(count="1 1 1", points=2, data="binary_compressed").encode()
                + np.array([4, 1 << 30], dtype="<u4").tobytes() + b"\0" * 4
            },
        ),
        "unpacks to 1073741824 bytes, expected 24",
    ),
}  # fmt: skip


HOSTILE.update({
    "labels that are text": (
        lambda at: saved(
            at / "a.npz", depth=np.ones((4, 5)), K=[[5, 0, 2], [0, 5, 2], [0, 0, 1]],
            label=np.full((4, 5), "mug"),
        ),
        "the labels are <U3: expected whole numbers",
    ),
    "tracks that are text": (lambda at: saved(at / "a.npz", depth="a", K="b", label="c"), "the labels are"),
    "NUL in the name of a file": (lambda at: named(at, "a\0.xyz"), "which no file can be: embedded null"),
    "half a character in the name of a file": (lambda at: named(at, "\ud800.xyz"), "which no file can be"),
    "a description that is a pipe": (lambda at: put(at, "scene.json", os.mkfifo), "is a pipe, a"),
    "a description that is a folder": (lambda at: put(at, "scene.json", os.mkdir), "is a pipe, a"),
    "a scene that is a pipe": (lambda at: put(at, "b.npz", os.mkfifo) / "b.npz", "neither a file nor"),
    "a description elsewhere": (lambda at: put(at, "scene.json", linked), "scene.json is not below"),
    "a cloud elsewhere": (lambda at: put(at, "b.xyz", linked), "b.xyz is not below the folder"),
    "notes elsewhere": (lambda at: put(at, "b.txt", linked), "b.txt is not below the folder"),
    "a mesh elsewhere": (lambda at: put(at, "b.ply", linked), "not below the folder"),
    "a camera elsewhere": (lambda at: put(at, "scene_camera.json", linked), "not below the folder"),
    "a recording elsewhere": (
        lambda at: put(put(at, "metadata.yaml", linked).parent, "x.mcap", linked), "not below the folder"
    ),
    "text of more rows than are allowed": (
        lambda at: folder(at / "f", {"a.xyz": "0 0 0\n" * 2_000_000}), "300 MB.*max_bytes=N"
    ),
    "numbers of a pcd that take more than they say": (
        lambda at: folder(
            at / "f",
            {"a.pcd": PCD.format(count="1 1 1", points=3_000_000, data="ascii").replace("H 2", "H 3000000")},
        ),
        "432 MB.*max_bytes=N",
    ),
    "json of fifty million lists": (
        lambda at: folder(at / "f", {"a.xyz": "0 0 0\n", "scene.json": '{"up": [' + "[]," * 5_000_000}),
        "480 MB.*max_bytes=N",
    ),
    "a number that is none of JSON": (
        lambda at: folder(at / "f", {"a.npy": npy(), "scene.json": '{"up": [0, 0, NaN]}'}), "NaN is no number"
    ),
    "a key given twice": (
        lambda at: folder(at / "f", {"a.npy": npy(), "scene.json": '{"up": [0, 0, 1], "up": [1, 0, 0]}'}),
        "the key 'up' twice",
    ),
    "a mass beyond all things": (
        lambda at: saved(at / "a.npz", a=CLOUD, masses='{"a": 1e308}'), "expected more than 0, up to 1e\\+06"
    ),
    "a picture that is a program": (
        lambda at: folder(
            at / "f",
            {
                "scene_camera.json": '{"0": {"cam_K": [5, 0, 2, 0, 5, 2, 0, 0, 1]}}',
                "scene_gt.json": '{"0": [{"obj_id": 1}]}',
                "depth/000000.png": POSTSCRIPT, "mask_visib/000000_000000.png": POSTSCRIPT,
            },
        ),
        "depth/000000.png is no picture: expected a PNG",
    ),
})  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_it_is_refused_in_one_line_with_little_memory(name, tmp_path):
    make, words = HOSTILE[name]
    path = make(tmp_path)
    tracemalloc.start()
    try:
        with pytest.raises(InvalidInput, match=words) as caught:
            load_scene(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    said = str(caught.value)
    assert said.startswith(str(path)) and "secret" not in said.lower()
    assert peak < 200e6


def test_the_limit_is_an_option(tmp_path):
    path = saved(tmp_path / "a.npz", a=CLOUD)
    with pytest.raises(InvalidInput, match="max_bytes=N"):
        load_scene(path, max_bytes=1000)
    assert load_scene(path, max_bytes=10_000).names == ("a",)


def test_an_lzma_archive_is_read(tmp_path):
    assert load_scene(zipped(tmp_path / "a.npz", npy(), zipfile.ZIP_LZMA)).names == ("a",)


def test_files_below_the_folder_are_read_and_others_only_where_that_is_allowed(tmp_path):
    folder(tmp_path / "elsewhere", {"secret.xyz": "0 0 0\n0.1 0 0\n0 0.1 0\n"})
    told = json.dumps({"files": {"a": "../elsewhere/secret.xyz"}})
    scene = folder(tmp_path / "scene", {"scene.json": told})
    with pytest.raises(InvalidInput, match=r"not below the folder.*allow_outside=True"):
        load_scene(scene)
    assert load_scene(scene, allow_outside=True).names == ("a",)
    (scene / "link.xyz").symlink_to(tmp_path / "elsewhere" / "secret.xyz")
    (scene / "scene.json").write_text(json.dumps({"files": {"a": "link.xyz"}}))
    with pytest.raises(InvalidInput, match="not below the folder"):
        load_scene(scene)


def test_what_a_mesh_names_is_neither_read_nor_run(tmp_path, monkeypatch):
    scene = put(tmp_path, "b.mtl", linked)
    (scene / "b.mtl").unlink()
    (scene / "b.obj").write_text("mtllib ../secret.mtl\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nusemtl a\nf 1 2 3\n")
    opened: list[str] = []
    sys.addaudithook(lambda event, args: opened.append(str(args[0])) if event == "open" else None)
    assert load_scene(scene).names == ("a", "b")
    assert any(name.endswith("b.obj") for name in opened) and not any("secret" in name for name in opened)


def test_models_and_frames_elsewhere_are_read_only_where_that_is_allowed(tmp_path):
    outside, frames, models = (
        saved(tmp_path / "secret.npz", a=CLOUD),
        tmp_path / "frames",
        tmp_path / "models",
    )
    folder(frames, {})
    (frames / "0.npz").symlink_to(outside)
    with pytest.raises(InvalidInput, match="not below the folder"):
        list(load_sequence(frames))
    assert [each.names for each in load_sequence(frames, allow_outside=True)] == [("a",)]
    linked(folder(models, {}) / "a.obj")
    with pytest.raises(InvalidInput, match="not below the folder"):
        load_scene(outside, models=models)


def test_a_compressed_pcd_is_read_fast_and_never_beyond_what_it_declares(tmp_path):
    count = 375_000  # 4.5 MB, the longest repetitions of one literal
    size = 12 * count
    runs, rest = divmod(size - 1, 264)
    packed = bytes([0, 0]) + bytes([0xE0, 255, 0]) * runs + bytes([0xE0, rest - 9, 0])
    header = PCD.format(count="1 1 1", points=count, data="binary_compressed").encode()
    header = header.replace(b"WIDTH 2", b"WIDTH %d" % count)
    for more in (0, 1):  # what unpacks to more is left where it passes the end
        body = packed + bytes([0xE0, 255, 0]) * (100_000 * more)
        (tmp_path / "a.pcd").write_bytes(header + np.array([len(body), size], dtype="<u4").tobytes() + body)
        begun = time.process_time()
        with pytest.raises(InvalidInput) if more else nullcontext():
            assert len(load_scene(tmp_path).clouds["a"]) == count
        assert time.process_time() - begun < 5.0
