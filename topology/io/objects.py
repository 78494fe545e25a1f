"""Scenes of what other libraries hold: Open3D and trimesh objects, records of a PointCloud2, poses of ROS."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import Names, as_names, as_points, as_pose
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.geometry.rigid import move_points
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.bag import labelled_points
from topple.topology.io.geometry import Geometry, sampled_mesh
from topple.topology.io.labelled import parts_from_labelled
from topple.topology.io.pcd import LABELS
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene

EXPECTED = "points (N, 3), a record array with x, y, z, or an Open3D or trimesh cloud or mesh, in metres"


@checked_arguments
def scene_from_objects(
    objects: Mapping[str, Any],
    poses: Mapping[str, Any] | Sequence[Any] = (),
    *,
    fixed: Names = (),
    up: ArrayLike | None = None,
    viewpoints: ArrayLike | None = None,
    robot_base: Any = None,
    masses: Mapping[str, float] | None = None,
    friction: Mapping[str, float] | None = None,
    centres: Mapping[str, ArrayLike] | None = None,
) -> Scene:
    """Make a scene of clouds and meshes of any of these libraries, none of which is imported.

    Args:
        objects: name -> points (N, 3), a record array with the fields x, y, z as PointCloud2 messages are
            read, an Open3D PointCloud or TriangleMesh (legacy or tensor), or a trimesh Trimesh, PointCloud
            or Scene, all in [m]. Meshes are sampled over their surface.
        poses: Where the objects are, by name or in their order: (4, 4) object to world, or a Pose or
            PoseStamped of ROS; those that have none are in the world's frame already.
        fixed: Names of the objects that never move.
        up: Direction (3,) against gravity; the normal of what is fixed where None.
        viewpoints: Camera centres (k, 3) in [m].
        robot_base: Pose of the robot's base, as one of `poses`.
        masses: In [kg] by name.
        friction: Coefficients by name.
        centres: Centres of mass (3,) in [m] by name, in the world.

    Returns:
        The scene.

    Raises:
        InvalidInput: An object is none of these or empty, a pose is none, or poses are in different frames.
        UnknownObject: A pose, or a name in `fixed`, is of no object.

    Examples:
        >>> scene_from_objects({"cup": scene.clouds["cup"], "book": scene.clouds["book"]}).names
        ('cup', 'book')
    """
    placed = dict(zip(objects, poses, strict=False)) if not isinstance(poses, Mapping) else dict(poses)
    if not isinstance(poses, Mapping) and len(poses) not in (0, len(objects)):
        raise InvalidInput(
            f"{len(poses)} poses for {len(objects)} objects: expected one for each, or by name"
        )
    for name in placed:
        if name not in objects:
            raise UnknownObject(name, objects, role="object with a pose")
    every = {**{f"pose of {name!r}": pose for name, pose in placed.items()}, "robot_base": robot_base}
    frames = {what: frame for what, pose in every.items() if (frame := _frame(pose))}
    if len(set(frames.values())) > 1:
        told = ", ".join(f"{what} in {frame}" for what, frame in frames.items())
        raise InvalidInput(f"poses are in different frames: {told}; expected one frame for all")
    fixed = as_names(fixed)
    parts = Parts({}, fixed, up, viewpoints, masses=masses, friction=friction, centres=centres)
    if robot_base is not None:
        parts.robot_base = pose_of(robot_base, "robot_base")
    for name, thing in objects.items():
        points, faces, vertices = geometry_of(thing, f"cloud {name!r}")
        if (pose := placed.get(name)) is not None:
            matrix = pose_of(pose, f"pose of {name!r}")
            points, vertices = (move_points(each, matrix) for each in (points, vertices))
        parts.clouds[name] = points
        if faces is not None:
            parts.meshes[name] = Mesh(as_points(vertices, f"mesh {name!r}"), faces)
    return assemble(parts, [], None)


@checked_arguments
def scene_from_points(
    points: Any,
    labels: ArrayLike | None = None,
    *,
    names: Mapping[int, str] | None = None,
    fixed: Names = (),
    up: ArrayLike | None = None,
    viewpoints: ArrayLike | None = None,
) -> Scene:
    """Make a scene of one cloud with a label per point.

    Args:
        points: A PointCloud2 message, a record array with x, y, z as one is read, or (N, 3), in [m].
        labels: (N,) whole numbers, 0 = background; None where the cloud has a field label, object_id, object
            or instance.
        names: What labels are called; the others by their number.
        fixed: Names, or labels, of what never moves.
        up: Direction (3,) against gravity.
        viewpoints: Camera centres (k, 3) in [m].

    Returns:
        The scene; points with NaN are left out.

    Raises:
        InvalidInput: There are no labels, or they do not fit.

    Examples:
        >>> points = np.concatenate([scene.clouds["cup"], scene.clouds["book"]])
        >>> scene_from_points(points, np.repeat([1, 2], 3000)).names
        ('1', '2')
    """
    if hasattr(points, "point_step") and labels is None:
        cloud, label = labelled_points(points, "the cloud")
    else:
        array = np.asarray(points)
        cloud = _records(array) if array.dtype.names is not None else array
        label = labels
        if label is None and array.dtype.names is not None:
            field = next((name for name in LABELS if name in array.dtype.names), None)
            label = None if field is None else array[field].ravel()
        if label is None:
            raise InvalidInput(f"the cloud has no labels: give labels (N,), or a field {' or '.join(LABELS)}")
    numbers = np.asarray(label).ravel()
    if numbers.dtype.kind == "f" and np.isfinite(numbers).all() and (numbers == np.round(numbers)).all():
        numbers = numbers.astype(np.int64)  # fields of a PointCloud2 are often floats
    called = dict(names or {})
    arrays: dict[str, Any] = {"points": cloud, "labels": numbers}
    if called:
        arrays["ids"], arrays["names"] = np.array(list(called)), np.array(list(called.values()))
    known = {str(number): name for number, name in called.items()}
    parts = parts_from_labelled(arrays)
    parts.up, parts.viewpoints = up, viewpoints
    return assemble(parts, [known.get(str(name), str(name)) for name in as_names(fixed)], None)


def geometry_of(thing: Any, what: str) -> Geometry:
    """Take in one object of another library.

    Args:
        thing: As an object of `scene_from_objects`.
        what: What it is, for messages.

    Returns:
        The cloud (N, 3) in [m], the mesh's faces (F, 3) or None for a cloud, and the mesh's vertices (V, 3).

    Raises:
        InvalidInput: It is none of these, or holds nothing.
    """
    if hasattr(thing, "to_geometry"):  # trimesh's scenes, all of their parts where they are
        thing = thing.to_geometry()
    if hasattr(thing, "to_legacy"):  # Open3D's tensors, which may be on a graphics card
        thing = thing.to_legacy()
    vertices = getattr(thing, "vertices", None)
    faces = getattr(thing, "faces", getattr(thing, "triangles", None))
    if vertices is not None and faces is not None and len(faces):
        corners = as_points(np.asarray(vertices, dtype=np.float64), what)
        triangles = np.asarray(faces).astype(np.int64)
        return sampled_mesh(corners, triangles), triangles, corners
    for held in (getattr(thing, "points", None), vertices, thing):
        if held is not None:
            break
    try:
        array = np.asarray(held)
    except ValueError as error:  # ragged
        raise InvalidInput(f"{what} is ragged: expected {EXPECTED}") from error
    if array.dtype.names is not None:
        array = _records(array)
        array = array[np.isfinite(array).all(axis=1)]
    elif array.dtype == object:
        raise InvalidInput(f"{what} is a {type(thing).__name__}: expected {EXPECTED}")
    points = as_points(array, what)
    return points, None, points


def pose_of(pose: Any, what: str) -> FloatArray:
    """A pose (4, 4) of a matrix, or of a Pose or PoseStamped of ROS.

    Raises:
        InvalidInput: It is none of these, or its quaternion is zero.
    """
    inner = getattr(pose, "pose", pose)
    if not (hasattr(inner, "position") and hasattr(inner, "orientation")):
        return as_pose(pose, what)
    place, turn = inner.position, inner.orientation
    quaternion = np.array([turn.x, turn.y, turn.z, turn.w], dtype=np.float64)
    if not np.isfinite(quaternion).all() or np.linalg.norm(quaternion) < 0.1:
        raise InvalidInput(f"{what} has the quaternion {quaternion.tolist()}: expected one of length 1")
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    matrix[:3, 3] = [place.x, place.y, place.z]
    return as_pose(matrix, what)


def _frame(pose: Any) -> str:
    """The frame that a stamped pose is in; "" where it does not say."""
    return str(getattr(getattr(pose, "header", None), "frame_id", ""))


def _records(array: Any) -> FloatArray:
    """(N, 3) the x, y, z of a record array of any shape."""
    missing = [axis for axis in "xyz" if axis not in array.dtype.names]
    if missing:
        raise InvalidInput(f"the record has the fields {', '.join(array.dtype.names)}: expected x, y and z")
    return np.stack([array[axis].astype(np.float64).ravel() for axis in "xyz"], axis=1)
