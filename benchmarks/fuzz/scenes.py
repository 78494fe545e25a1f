"""Small sound scenes in every format that `load_scene` and `load_sequence` take."""

import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from topple.benchmarks.fuzz.oracle import wrong_arrays, wrong_numbers, wrong_pixels, wrong_scene
from topple.benchmarks.fuzz.reader import Parts, Reader
from topple.topology.base.arrays import FloatArray
from topple.topology.io import load_scene, load_sequence
from topple.topology.scene.scene import Scene

_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.08
_FACES = ((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6))


def npy(array: object) -> bytes:
    """An array as numpy stores it; what is none as a pickle in one."""
    buffer = io.BytesIO()
    np.save(buffer, np.asarray(array), allow_pickle=True)
    return buffer.getvalue()


def cloud(count: int = 24) -> FloatArray:
    """Points (N, 3) [m] of a box of 8 cm."""
    return np.random.default_rng(0).uniform(0.0, 0.08, (count, 3)).round(4)


def _clouds() -> Parts:
    arrays: dict[str, object] = {
        "mug": cloud(),
        "table": cloud() * [4, 4, 0],
        "up": [0.0, 0.0, 1.0],
        "fixed": ["table"],
        "viewpoints": [[0.3, 0.3, 0.8]],
        "robot_base": np.eye(4),
        "masses": json.dumps({"mug": 0.35}),
        "friction": json.dumps({"mug": 0.6}),
    }
    return {f"{name}.npy": npy(array) for name, array in arrays.items()}


def _labelled() -> Parts:
    arrays: dict[str, object] = {
        "points": np.concatenate([cloud(), cloud() + np.array([0.1, 0.0, 0.0])]),
        "labels": np.repeat([1, 2], 24),
        "names": ["", "cup", "plate"],
        "table_plane": [0.0, 0.0, 1.0, 0.01],
    }
    return {f"{name}.npy": npy(array) for name, array in arrays.items()}


def _frame() -> dict[str, object]:
    label = np.zeros((12, 16), dtype=np.uint8)
    label[2:6, 2:7], label[7:11, 8:14] = 1, 2
    intrinsics = np.array([[20.0, 0.0, 8.0], [0.0, 20.0, 6.0], [0.0, 0.0, 1.0]])
    depth = 0.5 + 0.01 * np.random.default_rng(0).random((12, 16))
    return {"depth": depth, "K": intrinsics, "label": label, "pose_camera_to_world": np.eye(4)}


def _rgbd() -> Parts:
    frame = {**_frame(), "rgb": np.zeros((12, 16, 3), dtype=np.uint8), "fixed": ["2"]}
    return {f"{name}.npy": npy(array) for name, array in frame.items()}


def _masks() -> Parts:
    frame = _frame()
    label = np.asarray(frame.pop("label"))
    frame["masks"] = [label == 1, label == 2]
    return {f"{name}.npy": npy(array) for name, array in frame.items()}


def _record() -> Parts:
    arrays = {name: np.asarray(array) for name, array in _frame().items()}
    record = np.zeros(1, dtype=[(name, array.dtype, array.shape) for name, array in arrays.items()])
    for name, array in arrays.items():
        record[name][0] = array
    return {"frame.npy": npy(record)}


def _sequence() -> Parts:
    arrays: dict[str, object] = {
        "bowl_xyz_01mm": (1e4 * cloud(60)).astype(np.int16),
        "bowl_offsets": [0, 30, 60],
        "up": [0.0, 0.0, 1.0],
        "table_plane": [0.0, 0.0, 1.0, 0.0],
    }
    return {f"{name}.npy": npy(array) for name, array in arrays.items()}


def _folder() -> Parts:
    pose = np.eye(4)
    pose[0, 3] = 0.2
    told = {
        "up": [0, 0, 1], "fixed": ["table"], "viewpoints": [[0, 0, 1]], "poses": {"mug": pose.tolist()},
        "files": {"mug": "a.xyz"}, "masses": {"mug": 0.35}, "friction": {"mug": 0.6},
    }  # fmt: skip
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in cloud())
    return {"scene.json": json.dumps(told).encode(), "a.xyz": rows.encode(), "table.xyz": rows.encode()}


def _pcd(kind: str) -> Callable[[], Parts]:
    def parts() -> Parts:
        points = cloud().astype("<f4")
        header = (
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 24\n"
            f"HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 24\nDATA {kind}\n"
        ).encode()
        if kind == "ascii":
            return {"mug.pcd": header + "".join(f"{x} {y} {z}\n" for x, y, z in points).encode()}
        if kind == "binary":
            return {"mug.pcd": header + points.tobytes()}
        flat = points.T.tobytes()
        runs = [bytes([31]) + flat[i : i + 32] for i in range(0, len(flat), 32)]  # all literal, 32 each
        runs[-1] = bytes([len(runs[-1]) - 2]) + runs[-1][1:]
        packed = b"".join(runs)
        return {"mug.pcd": header + struct.pack("<II", len(packed), len(flat)) + packed}

    return parts


def _labelled_pcd() -> Parts:
    rows = "".join(f"{x} {y} {z} {1 + k % 2}\n" for k, (x, y, z) in enumerate(cloud()))
    header = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 24\n"
        "HEIGHT 1\nVIEWPOINT 0 0 1 1 0 0 0\nPOINTS 24\nDATA ascii\n"
    )
    return {"scene.pcd": (header + rows).encode()}


def _ply(kind: str, faces: bool) -> Callable[[], Parts]:
    def parts() -> Parts:
        points = (_CORNERS if faces else cloud()).astype("<f4")
        head = f"ply\nformat {kind} 1.0\nelement vertex {len(points)}\n"
        head += "property float x\nproperty float y\nproperty float z\n"
        head += f"element face {len(_FACES)}\nproperty list uchar int vertex_indices\n" if faces else ""
        head += "end_header\n"
        told = _FACES if faces else ()
        if kind == "ascii":
            lines = [f"{x} {y} {z}" for x, y, z in points] + [f"3 {a} {b} {c}" for a, b, c in told]
            return {"mug.ply": (head + "\n".join(lines) + "\n").encode()}
        return {
            "mug.ply": head.encode() + points.tobytes() + b"".join(struct.pack("<B3i", 3, *f) for f in told)
        }

    return parts


def _xyz() -> Parts:
    return {"mug.xyz": "\n".join(f"{x} {y}, {z} # seen" for x, y, z in cloud()).encode()}


def _obj() -> Parts:
    lines = [f"v {x} {y} {z}" for x, y, z in _CORNERS] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in _FACES]
    return {"mug.obj": ("\n".join(lines) + "\n").encode()}


def _groups() -> Parts:
    corners = [f"v {x} {y} {z + 0.2 * k}" for k in (0, 1) for x, y, z in _CORNERS]
    faces = [[f"f {a + at} {b + at} {c + at}" for a, b, c in _FACES] for at in (1, 1 + len(_CORNERS))]
    return {"scene.obj": "\n".join([*corners, "o mug", *faces[0], "o lid", *faces[1], ""]).encode()}


def _nodes() -> Parts:
    import trimesh

    scene = trimesh.Scene()
    for name, height in (("mug", 0.0), ("lid", 0.2)):
        mesh = trimesh.Trimesh(_CORNERS, _FACES, process=False)
        scene.add_geometry(
            mesh, name, name, transform=trimesh.transformations.translation_matrix([0, height, 0])
        )
    written: Any = scene.export(file_type="glb")
    return {"scene.glb": bytes(written)}


def _stl(binary: bool) -> Callable[[], Parts]:
    def parts() -> Parts:
        triangles = [_CORNERS[list(face)] for face in _FACES]
        if binary:
            bodies = (struct.pack("<12fH", 0, 0, 0, *corners.ravel(), 0) for corners in triangles)
            return {"mug.stl": bytes(80) + struct.pack("<I", len(triangles)) + b"".join(bodies)}
        lines = ["solid mug"]
        for corners in triangles:
            lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in corners)]
            lines += ["endloop", "endfacet"]
        return {"mug.stl": "\n".join([*lines, "endsolid mug", ""]).encode()}

    return parts


def _png(pixels: NDArray[Any]) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()


def _bop() -> Parts:
    frame = _frame()
    K, label = np.asarray(frame["K"]).ravel().tolist(), np.asarray(frame["label"])
    truth = [{"obj_id": k, "cam_R_m2c": np.eye(3).ravel().tolist(), "cam_t_m2c": [0, 0, 500]} for k in (1, 2)]
    masks = {f"mask_visib/000000_00000{k}.png": _png((label == k + 1).astype(np.uint8)) for k in (0, 1)}
    return {
        "scene_camera.json": json.dumps({"0": {"cam_K": K, "depth_scale": 1.0}}).encode(),
        "scene_gt.json": json.dumps({"0": truth}).encode(),
        "depth/000000.png": _png((1e3 * np.asarray(frame["depth"])).astype(np.uint16)),
        **masks,
    }


def _wrong_clouds(answer: object, path: Path) -> str | None:
    return wrong_numbers(list(answer.clouds.values())) if isinstance(answer, Scene) else "no scene"


def _frames(path: Path) -> list[object]:
    return list(load_sequence(path))


def _wrong_frames(answer: object, path: Path) -> str | None:
    frames = answer if isinstance(answer, list) else [answer]
    return next((said for frame in frames if (said := wrong_scene(frame, path)) is not None), None)


SCENES = (
    Reader("npz of clouds", _clouds, load_scene, wrong_arrays, "scene.npz", packed=True),
    Reader("npz with labels", _labelled, load_scene, wrong_scene, "scene.npz", packed=True),
    Reader("npz of depth and labels", _rgbd, load_scene, wrong_pixels, "frame.npz", packed=True),
    Reader("npz of depth and masks", _masks, load_scene, wrong_pixels, "frame.npz", packed=True),
    Reader("npy record", _record, load_scene, wrong_pixels, "frame.npy"),
    Reader("npz sequence", _sequence, _frames, _wrong_frames, "sequence.npz", packed=True),
    Reader("folder with scene.json", _folder, load_scene, wrong_scene),
    Reader("folder of bop", _bop, load_scene, _wrong_clouds),
    Reader("pcd ascii", _pcd("ascii"), load_scene, wrong_scene),
    Reader("pcd binary", _pcd("binary"), load_scene, wrong_scene),
    Reader("pcd compressed", _pcd("binary_compressed"), load_scene, wrong_scene),
    Reader("pcd with labels", _labelled_pcd, load_scene, wrong_scene, "scene.pcd"),
    Reader("ply ascii", _ply("ascii", faces=False), load_scene, wrong_scene),
    Reader("ply ascii mesh", _ply("ascii", faces=True), load_scene, wrong_scene),
    Reader("ply binary", _ply("binary_little_endian", faces=False), load_scene, wrong_scene),
    Reader("ply binary mesh", _ply("binary_little_endian", faces=True), load_scene, wrong_scene),
    Reader("xyz", _xyz, load_scene, wrong_scene),
    Reader("obj", _obj, load_scene, wrong_scene),
    Reader("obj of groups", _groups, load_scene, _wrong_clouds, "scene.obj"),
    Reader("glb of nodes", _nodes, load_scene, _wrong_clouds, "scene.glb"),
    Reader("stl ascii", _stl(binary=False), load_scene, wrong_scene),
    Reader("stl binary", _stl(binary=True), load_scene, wrong_scene),
)
