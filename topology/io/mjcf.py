"""Scenes of MuJoCo: an MJCF file at a keyframe, or a model and its data in a running simulation."""

from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.checks import Names, as_names
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.geometry import sampled_mesh
from topple.topology.io.limits import allow_below, read_bytes, read_text
from topple.topology.io.tolerances import AROUND, ROUND_SIDES
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene

_DIRECTORIES = {"mesh": "meshdir", "hfield": "assetdir", "texture": "texturedir", "skin": "assetdir"}


def reads(path: Path) -> bool:
    """Whether it is an XML file of MuJoCo."""
    if path.suffix.lower() != ".xml" or not path.is_file():
        return False
    with path.open("rb") as file:
        return b"<mujoco" in file.read(1 << 16)


def read(path: Path, keyframe: str | int | None = None) -> Parts:
    """Read a scene as it is at a keyframe.

    Args:
        path: The MJCF file; what it includes and the meshes it names lie below its folder.
        keyframe: Name or number of the keyframe; the initial pose where None.

    Returns:
        What it says: a mesh for each tree of bodies, of its collision geometry.

    Raises:
        InvalidInput: MuJoCo cannot read it, it has no such keyframe, or nothing in it can be touched.
        NotInstalled: MuJoCo is not there.
        OSError: A file cannot be read.
    """
    return parts_from_mjcf(read_text(path, path.name), path.parent, keyframe)


def parts_from_mjcf(text: str, folder: Path, keyframe: str | int | None = None) -> Parts:
    """Take a scene from the text of an MJCF file; see `read`.

    Args:
        text: The MJCF.
        folder: What it includes and the meshes it names lie below.
        keyframe: Name or number of the keyframe; the initial pose where None.
    """
    mujoco = _engine()
    files: dict[str, bytes] = {}
    with allow_below(folder):
        _collect(text, folder, files, {})
    try:
        model = mujoco.MjModel.from_xml_string(text, files)
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"MuJoCo cannot read it: {' '.join(str(error).split())[:200]}") from error
    data = mujoco.MjData(model)
    if keyframe is not None:
        number = _keyframe(mujoco, model, keyframe)
        mujoco.mj_resetDataKeyframe(model, data, number)
    mujoco.mj_forward(model, data)
    return _parts(mujoco, model, data, {}, frozenset())


@checked_arguments
def scene_from_mujoco(
    model: Any,
    data: Any,
    *,
    names: Mapping[int, str] | None = None,
    fixed: Names = (),
    ignore: Iterable[str] = (),
) -> Scene:
    """Take a scene from a running MuJoCo simulation, as it is now.

    An object is a tree of bodies below the world; it can move where its root has a free joint, and what hangs
    on other joints counts as fixed. Meshes are their convex hulls, as MuJoCo collides them.

    Args:
        model: The `mujoco.MjModel`.
        data: Its `mujoco.MjData`, after `mj_forward` or a step.
        names: Names by the number of the root body; others are called as in the model.
        fixed: Names of what never moves besides.
        ignore: Names of objects to leave out: robots.

    Returns:
        The scene: meshes, clouds of them, masses, centres of mass and friction. MuJoCo takes the greater
        coefficient of two surfaces; each has its root here, so that those of two alike are the same.

    Raises:
        InvalidInput: The two are no model and data, nothing can be touched, or nothing was computed yet.
        UnknownObject: `fixed` names something that is not there.

    Examples:
        >>> import mujoco
        >>> body = "<body name='cup' pos='0 0 0.1'><freejoint/><geom size='0.04'/></body>"
        >>> model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
        >>> data = mujoco.MjData(model)
        >>> mujoco.mj_forward(model, data)
        >>> scene_from_mujoco(model, data).names
        ('cup',)
    """
    engine = _engine()
    if not isinstance(model, engine.MjModel) or not isinstance(data, engine.MjData):
        raise InvalidInput(
            f"got {type(model).__name__} and {type(data).__name__}: expected a mujoco.MjModel and its MjData"
        )
    if not np.any(data.xpos) and model.nbody > 1 and not np.any(data.geom_xpos):
        raise InvalidInput(
            "nothing was computed of this world yet: call mujoco.mj_forward(model, data) before"
        )
    parts = _parts(engine, model, data, dict(names or {}), frozenset(ignore))
    return assemble(parts, as_names(fixed), None)


def _engine() -> Any:
    if find_spec("mujoco") is None:
        raise NotInstalled("scenes of MuJoCo need it", "mujoco")
    import mujoco

    return mujoco


def _collect(text: str, folder: Path, files: dict[str, bytes], directories: dict[str, str]) -> None:
    """Read every file that an MJCF text names, through the gate of all files, under the names it uses."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InvalidInput("it declares entities: expected plain MJCF, without <!DOCTYPE>")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InvalidInput(f"it is broken XML ({error}): write it again") from error
    for compiler in root.iter("compiler"):
        directories |= {key: compiler.attrib[key] for key in _DIRECTORIES.values() if key in compiler.attrib}
    for element in root.iter():
        for name in (value for key, value in element.attrib.items() if key.startswith("file")):
            kind = _DIRECTORIES.get(element.tag)
            below = "" if kind is None else directories.get(kind, directories.get("assetdir", ""))
            place = Path(below, name)
            found = read_bytes(folder / place, f"the file {name!r} that it names")
            if files.setdefault(place.name, found) != found:  # MuJoCo looks for it without its folder
                raise InvalidInput(f"it names two files called {place.name!r}: expected names of their own")
            if element.tag == "include":
                _collect(found.decode("utf-8", "replace"), folder, files, directories)
            elif element.tag == "model" and place.suffix.lower() == ".xml":  # another model, attached
                _collect(found.decode("utf-8", "replace"), folder, files, {})


def _keyframe(mujoco: Any, model: Any, wanted: str | int) -> int:
    known = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_KEY, k) or str(k) for k in range(model.nkey)]
    if str(wanted) in known:
        return known.index(str(wanted))
    if str(wanted).isdigit() and int(wanted) < model.nkey:
        return int(wanted)
    raise InvalidInput(f"it has no keyframe {wanted}: it has {', '.join(known) or 'none'}")


def _parts(mujoco: Any, model: Any, data: Any, names: Mapping[int, str], ignored: frozenset[str]) -> Parts:
    """The objects of a model, each with its mesh, and what never moves."""
    solid = [g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g]]
    owner = {g: _owner(mujoco, model, g, names) for g in solid}
    solid = [g for g in solid if owner[g] not in ignored]
    limits = [data.geom_xpos[g] for g in solid if model.geom_type[g] != mujoco.mjtGeom.mjGEOM_PLANE]
    around = (np.min(limits, axis=0), np.max(limits, axis=0)) if limits else (np.zeros(3), np.zeros(3))
    pieces: dict[str, list[tuple[FloatArray, IntArray]]] = {}
    rough: dict[str, float] = {}
    notes = ["meshes are the collision geometry of MuJoCo, meshes as their convex hulls"]
    roots: dict[str, int] = {}
    for g in solid:
        shape = _shape(mujoco, model, g, data, around)
        if shape is None:
            notes.append(f"a geom of {owner[g]!r} is neither primitive nor mesh: it is left out")
            continue
        pieces.setdefault(owner[g], []).append(shape)
        rough[owner[g]] = float(np.sqrt(model.geom_friction[g, 0]))
        roots[owner[g]] = int(model.body_rootid[model.geom_bodyid[g]])
    if not pieces:
        raise InvalidInput("nothing in it can be touched: expected geoms that collide")
    meshes = {name: _join(some) for name, some in pieces.items()}
    free = {name: body for name, body in roots.items() if _is_free(mujoco, model, body)}
    gravity = np.asarray(model.opt.gravity, dtype=np.float64)
    return Parts(
        clouds={name: sampled_mesh(mesh.vertices, mesh.faces) for name, mesh in meshes.items()},
        fixed=[name for name in meshes if name not in free],
        up=-gravity / np.linalg.norm(gravity) if np.any(gravity) else None,
        meshes=meshes,
        notes=notes,
        masses={name: float(model.body_subtreemass[body]) for name, body in free.items()},
        friction=rough,
        centres={name: data.subtree_com[body].tolist() for name, body in free.items()},
    )


def _owner(mujoco: Any, model: Any, geom: int, names: Mapping[int, str]) -> str:
    """The object that a geom is of: its tree of bodies, or itself where it is the world's."""
    body = int(model.body_rootid[model.geom_bodyid[geom]])
    kind, number = (mujoco.mjtObj.mjOBJ_BODY, body) if body else (mujoco.mjtObj.mjOBJ_GEOM, geom)
    given = names.get(body) if body else None
    return given or mujoco.mj_id2name(model, kind, number) or f"{'body' if body else 'geom'}_{number}"


def _is_free(mujoco: Any, model: Any, body: int) -> bool:
    joint = model.body_jntadr[body]
    return body > 0 and joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE


def _shape(
    mujoco: Any, model: Any, geom: int, data: Any, around: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, IntArray] | None:
    """Corners (V, 3) in the world [m] and triangles (F, 3) of a geom; None of one without a surface."""
    kinds, size = mujoco.mjtGeom, np.asarray(model.geom_size[geom], dtype=np.float64)
    kind, turn = kinds(model.geom_type[geom]), np.asarray(data.geom_xmat[geom]).reshape(3, 3)
    place = np.asarray(data.geom_xpos[geom])
    if kind == kinds.mjGEOM_PLANE:
        low, high = (
            ((np.stack(around) - place) @ turn)[:, :2].min(axis=0),
            ((np.stack(around) - place) @ turn)[:, :2].max(axis=0),
        )
        half = np.where(size[:2] > 0, np.minimum(size[:2], 5.0), np.inf)
        low, high = np.maximum(low - AROUND, -half), np.minimum(high + AROUND, half)
        level = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
        return np.column_stack([level, np.zeros(4)]) @ turn.T + place, np.array([[0, 1, 2], [0, 2, 3]])
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        corners = np.asarray(model.mesh_vert[first : first + count], dtype=np.float64)
    elif kind == kinds.mjGEOM_BOX:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
    elif kind in (kinds.mjGEOM_SPHERE, kinds.mjGEOM_ELLIPSOID):
        corners = _sphere() * (size if kind == kinds.mjGEOM_ELLIPSOID else size[0])
    elif kind == kinds.mjGEOM_CAPSULE:
        ball = _sphere() * size[0]
        corners = np.concatenate([ball + np.array([0, 0, size[1]]), ball - np.array([0, 0, size[1]])])
    elif kind == kinds.mjGEOM_CYLINDER:
        angles = np.arange(ROUND_SIDES) * 2 * np.pi / ROUND_SIDES
        circle = size[0] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        corners = np.concatenate([np.insert(circle, 2, z, axis=1) for z in (-size[1], size[1])])
    else:
        return None
    try:
        return _hull(corners @ turn.T + place)
    except QhullError:
        return None


def _sphere() -> FloatArray:
    """Points (N, 3) of a unit sphere, evenly in a spiral: no two faces of their hull are in one plane."""
    count = ROUND_SIDES**2 // 4
    height = 1.0 - 2.0 * np.arange(count) / (count - 1)
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)


def _hull(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The convex hull of points as corners and triangles that are turned outwards."""
    hull = ConvexHull(points)
    place = np.zeros(len(points), dtype=np.int64)
    place[hull.vertices] = np.arange(len(hull.vertices))
    corners, faces = points[hull.vertices], place[hull.simplices]
    sides = corners[faces]
    out = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    inward = np.einsum("ij,ij->i", out, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return corners, faces


def _join(pieces: Iterable[tuple[FloatArray, IntArray]]) -> Mesh:
    corners, faces, count = list[FloatArray](), list[IntArray](), 0
    for points, triangles in pieces:
        corners.append(points)
        faces.append(triangles + count)
        count += len(points)
    return Mesh(np.concatenate(corners), np.concatenate(faces))
