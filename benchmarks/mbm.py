"""Motion problems of others: MotionBenchMaker's, as the source archive of vamp-planner has them.

Chamzas et al., "MotionBenchMaker" (RA-L 2022): shelves, boxes, a cage and tables, 100 problems of each, for a
Panda, a UR5 and a Fetch. `--data DIR` is the unpacked archive of vamp-planner 0.6.4 (PyPI), which brings the
arms' URDFs and meshes. A problem counts unless its start or goal touches something by the exact meshes,
looked up with python-fcl where topple refuses the goal. Solved is what has a certificate all along.
"""

import itertools
import re
import tarfile
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share_interval
from topple.planner.motion.collision import Checker, Contact
from topple.planner.motion.planner import Motion, plan_motion
from topple.robots import robot
from topple.robots.arm.arm import Arm
from topple.robots.arm.elements import numbers, origin_of
from topple.robots.arm.gripper_file import ArmPart, GripperFile
from topple.robots.arm.shapes import find_mesh, geometry_parts, prism
from topple.robots.arm.urdf import urdf_root
from topple.robots.collision.convex import hull_of
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import transformed

Primitive = tuple[str, Sequence[float], FloatArray]
"""Kind, sizes [m] and pose (4, 4) in the world, as the problems have them."""

ROBOTS = ("panda", "ur5", "fetch")
QUICK = 10
"""Of so many problems one, where it has to be quick."""


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Every tenth problem alone.
        seed: Of the searches.
        progress: Called before each kind of problem.
        data: The unpacked archive.

    Raises:
        InvalidInput: There is no problem in it, or PyYAML is not installed.
    """
    found = [row for name in ROBOTS for row in _rows_of(name, QUICK if quick else 1, seed, progress, data)]
    if not found:
        raise InvalidInput("mbm needs --data DIR: the unpacked source archive of vamp-planner")
    return [row.to_json() for row in found]


def _rows_of(name: str, every: int, seed: int, progress: Progress, data: Path | None) -> list[Row]:
    """The figures of one arm; none where it has no problems."""
    archive = None if data is None else data / "resources" / name / "problems.tar.bz2"
    if archive is None or not archive.exists():
        return []
    seconds: list[float] = []
    touching, wrong, arm = 0, list[str](), None
    for kind, number, scene, request in _problems(archive, every):
        progress(f"{kind}, problem {number}")
        asked = {
            each["joint_name"]: each["position"]
            for each in request["goal_constraints"][0]["joint_constraints"]
        }
        if arm is None:
            part = ArmPart(joints=list(asked))
            arm = robot(archive.with_name(f"{name}.urdf"), GripperFile(arm=part))
        state = request["start_state"]["joint_state"]
        start = dict(zip(state["name"], state["position"], strict=True))
        ends = np.array([[given[joint] for joint in arm.joints] for given in (start, asked)])
        endless = [arm.model.joint(joint).kind == "continuous" for joint in arm.joints]
        # rounded, some lie beyond a turn
        ends[:, endless] = (ends[:, endless] + np.pi) % (2.0 * np.pi) - np.pi
        obstacles = dict(_obstacles(scene))
        before = process_time()
        checker = Checker(arm, np.eye(4), {each: [polyhedron(*shape)] for each, shape in obstacles.items()})
        motion = plan_motion(checker, ends[0], ends[1:], seed=seed)
        seconds.append(process_time() - before)
        if isinstance(motion, Motion) and motion.certificate is not None and motion.certificate.proven:
            continue
        if any(_touches(arm, q, each, obstacles) for q in ends for each in checker.contacts(q)):
            touching += 1
            continue
        wrong.append(f"{kind} {number}: {'not certified' if isinstance(motion, Motion) else motion.reason}")
    tried = len(seconds) - touching
    held = tried - len(wrong)
    return [
        Row(
            "problems solved and certified", 100 * held / tried, "%", bar=">= 99.5",
            interval=share_interval(held, tried), tried=tried, held=held, wrong=tuple(wrong[:12]),
            column=name,
        ),
        Row("left out, as start or goal touches something by the exact meshes", touching, "", column=name),
        *(
            Row(f"CPU of a problem, {what}", 1e3 * float(np.quantile(seconds, share)), "ms", column=name)
            for what, share in (("median", 0.5), ("95 %", 0.95), ("worst", 1.0))
        ),
    ]  # fmt: skip


def _problems(archive: Path, every: int) -> Iterator[tuple[str, int, Any, Any]]:
    """Kind, number, scene and request of each problem, by name."""
    try:
        import yaml
    except ImportError as error:
        raise InvalidInput("mbm reads YAML: pip install 'topple-planner[yaml]'") from error
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    parts: dict[tuple[str, int], dict[str, bytes]] = defaultdict(dict)
    with tarfile.open(archive) as files:
        for member in files:
            named = re.fullmatch(r"problems/(\w+)/(scene|request)(\d+)\.yaml", member.name)
            if named is not None and int(named[3]) % every == 0 and (file := files.extractfile(member)):
                parts[named[1], int(named[3])][named[2]] = file.read()
    for (kind, number), texts in sorted(parts.items()):
        yield kind, number, *(yaml.load(texts[each], loader) for each in ("scene", "request"))


def _obstacles(scene: Any) -> Iterator[tuple[str, Primitive]]:
    for each in scene["world"]["collision_objects"]:
        whole = _pose(each["pose"]) if "pose" in each else np.eye(4)
        for k, (shape, place) in enumerate(zip(each["primitives"], each["primitive_poses"], strict=True)):
            yield f"{each['id']} {k}", (shape["type"], shape["dimensions"], whole @ _pose(place))


def polyhedron(kind: str, sizes: Sequence[float], pose_to_world: FloatArray) -> FloatArray:
    """(V, 3) corners in the world [m] of a body around a primitive, at most 2 % wider."""
    import trimesh

    if kind == "box":
        corners = trimesh.creation.box(sizes).vertices
    elif kind == "cylinder":
        corners = prism(sizes[1], sizes[0])
    else:  # an icosphere lies inside the ball: scaled so that its faces do not
        corners = trimesh.creation.icosphere(subdivisions=2, radius=1.02 * sizes[0]).vertices
    return transformed(np.asarray(corners, dtype=float), pose_to_world)


def _pose(given: Any) -> FloatArray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_quat(given["orientation"]).as_matrix(), given["position"]
    return pose


def _touches(arm: Arm, q: FloatArray, contact: Contact, obstacles: Mapping[str, Primitive]) -> bool:
    """Whether two things that touch by their convex parts do by the meshes themselves."""
    import fcl

    there = dict(zip(arm.links, arm.forward(q)[0], strict=True))
    sides = [
        [_primitive(*obstacles[name])] if name in obstacles else [
            fcl.CollisionObject(mesh, fcl.Transform(there[name][:3, :3], there[name][:3, 3]))
            for mesh in _meshes(arm.model.path, name)
        ]
        for name in (contact.a, contact.b)
    ]  # fmt: skip
    return any(
        fcl.collide(one, other, fcl.CollisionRequest(), fcl.CollisionResult())
        for one, other in itertools.product(*sides)
    )


@cache
def _meshes(path: Path, link: str) -> list[Any]:
    """The collision geometry of a link as its files have it, not made convex."""
    import fcl
    import trimesh

    found: list[Any] = []
    for element in urdf_root(path).iterfind(f"link[@name='{link}']/collision"):
        geometry = element.find("geometry")
        named = None if geometry is None else geometry.find("mesh")
        if named is not None:
            mesh: Any = trimesh.load_mesh(find_mesh(str(named.get("filename")), path))
            scale = numbers(named.get("scale"), 3, (1.0, 1.0, 1.0), "scale")
            pieces = [(np.asarray(mesh.vertices) * scale, np.asarray(mesh.faces))]
        else:
            pieces = [hull_of(part) for part in geometry_parts(geometry, path, "collision", [], None)]
        for vertices, faces in pieces:
            body = fcl.BVHModel()
            body.beginModel(len(vertices), len(faces))
            body.addSubModel(transformed(vertices, origin_of(element, "collision")), faces)
            body.endModel()
            found.append(body)
    return found


def _primitive(kind: str, sizes: Sequence[float], pose: FloatArray) -> Any:
    import fcl

    made = {"box": fcl.Box, "cylinder": lambda length, radius: fcl.Cylinder(radius, length)}
    return fcl.CollisionObject(made.get(kind, fcl.Sphere)(*sizes), fcl.Transform(pose[:3, :3], pose[:3, 3]))
