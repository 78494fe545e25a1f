"""An image of a BOP dataset: what its camera saw, or the models at their true poses.

Format: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md; lengths in millimetres.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_pose, numeric
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import FARTHEST_DEPTH, FEWEST_SEEN
from topple.topology.geometry.rigid import move_points
from topple.topology.io.archive import Array
from topple.topology.io.assemble import Parts
from topple.topology.io.geometry import read_geometry
from topple.topology.io.limits import allow_below, read_text
from topple.topology.io.picture import read_picture
from topple.topology.io.strict_json import read_json
from topple.topology.scene.mesh import Mesh
from topple.topology.views.image import DepthImage, check_depth

_CAMERAS, _TRUTH = "scene_camera.json", "scene_gt.json"
_MODELS = ("models", "models_cad", "models_fine", "models_reconst", "models_eval")
_DEPTHS = (".png", ".tif", ".tiff")
_MILLIMETRE = 1e-3  # [m]


def reads(path: Path) -> bool:
    """Tell the folder of a scene, such as test/000048, by the file of its cameras, or of what holds such."""
    return (path / _CAMERAS).is_file() or (path / _TRUTH).is_file() or _scene_below(path) is not None


def read(path: Path, image: int | None = None, models: bool = False) -> Parts:
    """Read one image of a scene.

    With depth and `mask_visib` each object is a cloud of what was seen of it; without them, or where it is
    asked for, its whole model at its true pose. The frame is the world's where the camera's pose is known
    (`cam_R_w2c`), else the camera's. An object is called as its model, `obj_000005`, a second one
    `obj_000005_2`. BOP knows no tables: it is looked for in the pixels without a mask.

    Args:
        path: The folder of the scene, with `scene_camera.json` and `scene_gt.json`.
        image: Number of the image; the first where None, which a note says.
        models: Whether the models are taken although there is depth.

    Returns:
        What the image says, in [m].

    Raises:
        InvalidInput: If there is no such image, or a file is missing or broken; names it.
        OSError: If a file cannot be read.
    """
    if (scene := _scene_below(path)) is not None:
        raise InvalidInput(f"is no scene, and holds scenes of BOP: give the folder of one, such as {scene}")
    cameras, truth = (_by_image(path / name) for name in (_CAMERAS, _TRUTH))
    number, notes = _choose_image(image, cameras)
    camera, poses = cameras[number], truth.get(number, [])
    if not isinstance(camera, dict):
        raise InvalidInput(f"{_CAMERAS}: image {number} is {camera!r}: expected cam_K and depth_scale")
    if not isinstance(poses, list) or not poses:
        raise InvalidInput(f"{_TRUTH} says nothing of image {number}: expected the poses of its objects")
    to_world = _camera_pose(cast(dict[str, Any], camera))
    names = _names(cast(list[Any], poses))
    seen = _depth_image(path, number, cast(dict[str, Any], camera), to_world, names, notes)
    if models or seen is None:
        if not models:
            _refuse_gap(path, number)
            notes.append("there is no depth with masks: the models at their true poses are taken")
        parts = _place_models(path, cast(list[Any], poses), names, to_world)
        parts.background = np.empty((0, 3)) if seen is None else seen.background()
    else:
        clouds = {name: cloud for name, cloud in seen.clouds().items() if len(cloud) >= FEWEST_SEEN}
        check_depth([seen], clouds)
        notes += [
            f"{name!r} is left out: hardly a pixel of it was seen" for name in names if name not in clouds
        ]
        parts = Parts(
            clouds=dict(clouds), viewpoints=seen.viewpoint, images=(seen,), background=seen.background()
        )
    parts.notes = notes
    return parts


def _scene_below(path: Path) -> Path | None:
    """A scene of the dataset, or of the part of one, whose folder this is; None where it is neither."""
    if (path / _CAMERAS).is_file() or (path / _TRUTH).is_file():
        return None
    found = (file for depth in ("*", "*/*") for file in sorted(path.glob(f"{depth}/{_CAMERAS}")))
    return next((file.parent for file in found), None)


def _refuse_gap(path: Path, number: int) -> None:
    """Refuse to take models in silence for an image whose depth is missing where that of others is there.

    Raises:
        InvalidInput: It is.
    """
    stem, folder = f"{number:06d}", path / "depth"
    others = sorted(file.name for file in folder.glob("*") if file.suffix in _DEPTHS)
    if others and _found(folder, stem, _DEPTHS) is None:
        raise InvalidInput(
            f"has no depth/{stem}.png, and has depth/{others[0]}: expected the depth of image {number}; "
            "models=True takes the models at their true poses"
        )


def _by_image(path: Path) -> dict[int, Any]:
    """A file of the scene: image number -> what it says."""
    if not path.is_file():
        raise InvalidInput(
            f"has no {path.name}: expected the folder of a scene whose truth is public, such as test/000048"
        )
    try:
        document = read_json(read_text(path, path.name), path.name)
        return {int(key): value for key, value in document.items()}
    except (AttributeError, ValueError) as error:
        raise InvalidInput(f'{path.name} is not by image: expected {{"0": ..., "1": ...}}') from error


def _choose_image(image: int | None, cameras: Mapping[int, Any]) -> tuple[int, list[str]]:
    """The image that is meant, and the note on one that was not named."""
    if not cameras:
        raise InvalidInput(f"{_CAMERAS} has no images: expected at least one")
    if image is None:
        first = min(cameras)
        rest = f"image {first} of {len(cameras)} is taken, the first: image=N takes another"
        return first, [rest] if len(cameras) > 1 else []
    if image not in cameras:
        known = sorted(cameras)
        listed = ", ".join(map(str, known[:8])) + (f", ... {known[-1]}" if len(known) > 8 else "")
        raise InvalidInput(f"has no image {image}: expected one of {listed}")
    return image, []


def _camera_pose(camera: Mapping[str, Any]) -> FloatArray:
    """(4, 4) pose_camera_to_world; of the camera itself where none is known."""
    if "cam_R_w2c" not in camera:
        return np.eye(4)
    return np.asarray(np.linalg.inv(_pose(camera, "w2c", _CAMERAS)), dtype=np.float64)


def _pose(entry: Mapping[str, Any], frames: str, where: str) -> FloatArray:
    """(4, 4) a rotation by rows and a translation in millimetres, such as cam_R_m2c and cam_t_m2c."""
    rotation = _numbers(entry, f"cam_R_{frames}", 9, where).reshape(3, 3)
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = _numbers(entry, f"cam_t_{frames}", 3, where) * _MILLIMETRE
    return as_pose(pose, f"cam_R_{frames} in {where}")


def _numbers(entry: Mapping[str, Any], key: str, count: int, where: str) -> FloatArray:
    values = numeric(entry.get(key, []), f"{key} in {where}")
    if values.shape != (count,):
        raise InvalidInput(f"{where}: {key} has shape {values.shape}: expected {count} numbers")
    return values


def _names(poses: list[Any]) -> dict[str, int]:
    """Name -> row of `scene_gt.json`, in its order."""
    named: dict[str, int] = {}
    counts: dict[int, int] = {}
    for row, entry in enumerate(poses):
        model: Any = cast(dict[str, Any], entry).get("obj_id") if isinstance(entry, dict) else None
        if not isinstance(model, int) or isinstance(model, bool) or model < 0:
            raise InvalidInput(f"{_TRUTH}: object {row} has the obj_id {model!r}: expected a whole number")
        counts[model] = counts.get(model, 0) + 1
        named[f"obj_{model:06d}" + (f"_{counts[model]}" if counts[model] > 1 else "")] = row
    return named


def _depth_image(
    path: Path,
    number: int,
    camera: Mapping[str, Any],
    to_world: FloatArray,
    names: Mapping[str, int],
    notes: list[str],
) -> DepthImage | None:
    """The depth image with the visible masks as labels, row + 1; None where there is no depth or no mask."""
    file = _found(path / "depth", f"{number:06d}", _DEPTHS)
    masks = {row: path / "mask_visib" / f"{number:06d}_{row:06d}.png" for row in names.values()}
    if file is None or not any(mask.is_file() for mask in masks.values()):
        return None
    scale = numeric(camera.get("depth_scale", 1.0), f"depth_scale in {_CAMERAS}")
    if scale.shape != () or not np.isfinite(scale) or scale <= 0:
        raise InvalidInput(
            f"{_CAMERAS}: depth_scale is {scale}: expected what makes depth millimetres, 0.1 or 1"
        )
    depth = _plane(file) * (float(scale) * _MILLIMETRE)
    if depth.max(initial=0.0) > FARTHEST_DEPTH:
        given = "" if "depth_scale" in camera else ", since none is given"
        raise InvalidInput(
            f"depth/{file.name} reaches {depth.max():.4g} m with depth_scale {scale:g} in {_CAMERAS}{given}: "
            f"expected at most {FARTHEST_DEPTH:g} m; depth_scale times the picture's numbers are millimetres"
        )
    label, claims = np.zeros(depth.shape, dtype=np.int64), np.zeros(depth.shape, dtype=np.int64)
    for row, mask in masks.items():
        covered = _plane(mask) > 0
        if covered.shape != depth.shape:
            raise InvalidInput(
                f"mask_visib/{mask.name} is {covered.shape} and the depth {depth.shape}: expected one size"
            )
        label[covered] = row + 1
        claims += covered
    if (claims > 1).any():
        depth[claims > 1] = 0.0
        notes.append(f"{int((claims > 1).sum())} pixels that several masks claim are left out")
    K = _numbers(camera, "cam_K", 9, _CAMERAS).reshape(3, 3)
    return DepthImage(depth, K, label, to_world, {row + 1: name for name, row in names.items()})


def _found(folder: Path, stem: str, suffixes: tuple[str, ...]) -> Path | None:
    return next((file for suffix in suffixes if (file := folder / (stem + suffix)).is_file()), None)


def _plane(file: Path) -> Array:
    """(H, W) of one channel."""
    what = f"{file.parent.name}/{file.name}"
    if not file.is_file():
        raise InvalidInput(f"has no {what}: expected one mask per object of {_TRUTH}")
    picture = read_picture(file, what)
    if picture.ndim != 2:
        raise InvalidInput(f"{what} has shape {picture.shape}: expected one channel (H, W)")
    return picture


def _place_models(path: Path, poses: list[Any], names: Mapping[str, int], to_world: FloatArray) -> Parts:
    """The models, which stand in a folder beside the split's, at their poses."""
    parts = Parts(clouds={})
    for name, row in names.items():
        file = _model(path, poses[row]["obj_id"])
        with allow_below(file.parents[1]):  # the models of a dataset stand beside its scenes
            points, faces, vertices = read_geometry(file, f"model {file.name}", _MILLIMETRE)
        pose = to_world @ _pose(poses[row], "m2c", f"{_TRUTH}, object {row}")
        points, vertices = (move_points(each, pose) for each in (points, vertices))
        parts.clouds[name] = points
        if faces is not None:
            parts.meshes[name] = Mesh(vertices, faces)
    return parts


def _model(path: Path, number: int) -> Path:
    stem = f"obj_{number:06d}"
    for dataset in path.resolve().parents[:3]:
        for folder in _MODELS:
            if (file := dataset / folder / f"{stem}.ply").is_file():
                return file
    raise InvalidInput(
        f"has no models/{stem}.ply in the dataset's folder: expected the models beside {path.parent.name}/"
    )
