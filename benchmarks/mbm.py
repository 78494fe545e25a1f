"""Motion problems of others: MotionBenchMaker's, as the source archive of vamp-planner has them.

Chamzas et al., "MotionBenchMaker" (RA-L 2022): shelves, boxes, a cage and tables, 100 problems of each, for a
Panda, a UR5 and a Fetch. `--data DIR` is the unpacked archive of vamp-planner 0.6.4 (PyPI), which brings the
arms' URDFs and meshes. A problem counts unless its start or goal touches something by the exact meshes,
looked up with python-fcl where topple refuses the goal. Solved is what has a certificate all along.
roboplan and VAMP, where installed, get the same goals and solids; what their paths touch is told apart.
"""

import itertools
import re
import tarfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from topple.benchmarks.motion_problems import Problem, Solid, checker_of
from topple.benchmarks.peers import Answer, answers, python_of
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.motion.planner import Motion, plan_motion
from topple.planner.motion.shortcut import densely
from topple.robots import robot
from topple.robots.arm.elements import numbers, origin_of
from topple.robots.arm.gripper_file import ArmPart, GripperFile
from topple.robots.arm.shapes import find_mesh, geometry_parts
from topple.robots.arm.urdf import urdf_root
from topple.robots.collision.convex import hull_of
from topple.robots.poses import pose_from
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points

ROBOTS = ("panda", "ur5", "fetch")
QUICK = 10
"""Of so many problems one, where it has to be quick."""

PEERS = ("roboplan", "vamp")
"""Run beside, where they are installed: see `topple.benchmarks.peers`."""

BUDGET = 5.0
"""[s] of a peer for one problem: 700 of Fetch take an hour at most."""

LOOKED_AT = 0.01
"""[rad] between the states of a peer's path that are looked at."""


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
    problems, seconds = list[Problem](), list[float]()
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
        checker = checker_of(arm, obstacles)
        motion = plan_motion(checker, ends[0], ends[1:], seed=seed)
        spent = process_time() - before
        solved = isinstance(motion, Motion) and motion.certificate is not None and motion.certificate.proven
        problem = Problem(obstacles, checker, ends[0], ends[1:])
        if not solved and _touches(problem, ends):
            touching += 1
            continue
        problems.append(problem)
        seconds.append(spent)
        if not solved:
            reason = "not certified" if isinstance(motion, Motion) else motion.reason
            wrong.append(f"{kind} {number}: {reason}")
    tried = len(problems)
    found = [
        share(
            "problems solved and certified", tried - len(wrong), tried, ">= 99.5", counted=True,
            wrong=wrong[:12], column=name,
        ),
        Row("left out: start or goal touches", touching, "", column=name),
        *_times(name, seconds),
    ]  # fmt: skip
    for peer in PEERS:
        if (python := python_of(peer)) is not None:
            progress(f"{name}: {peer}")
            found += _peer_rows(f"{name}, {peer}", problems, answers(peer, python, problems, seed, BUDGET))
    return found


def _times(column: str, seconds: Sequence[float]) -> list[Row]:
    return [
        Row(f"CPU of a problem, {what}", 1e3 * float(np.quantile(seconds, part)), "ms", column=column)
        for what, part in (("median", 0.5), ("95 %", 0.95), ("worst", 1.0))
    ]


def _peer_rows(column: str, problems: Sequence[Problem], found: Sequence[Answer]) -> list[Row]:
    """A path of a peer counts as solved, whatever it touches: that is a row of its own."""
    paths = [(p, a.path) for p, a in zip(problems, found, strict=True) if a.path is not None]
    touching = sum(_touches(problem, densely(path, LOOKED_AT)) for problem, path in paths)
    return [
        share("problems with a path, touching or not", len(paths), len(found), column=column),
        share(
            f"paths that touch, by exact meshes every {LOOKED_AT} rad", touching, len(paths), column=column
        ),
        *_times(column, [answer.seconds for answer in found]),
    ]


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


def _obstacles(scene: Any) -> Iterator[tuple[str, Solid]]:
    for each in scene["world"]["collision_objects"]:
        whole = _pose(each["pose"]) if "pose" in each else np.eye(4)
        for k, (shape, place) in enumerate(zip(each["primitives"], each["primitive_poses"], strict=True)):
            yield f"{each['id']} {k}", Solid(shape["type"], shape["dimensions"], whole @ _pose(place))


def _pose(given: Any) -> FloatArray:
    return pose_from(given["position"], given["orientation"])


def _touches(problem: Problem, states: FloatArray) -> bool:
    """Whether anything touches by the meshes themselves in one of (m, n) states."""
    import fcl

    checker = problem.checker
    for q in states[~checker.free(states)]:  # the convex parts hold the meshes
        there = dict(zip(checker.arm.links, checker.arm.forward(q)[0], strict=True))
        for contact in checker.contacts(q):
            sides = [
                [_solid(problem.boxes[name])] if name in problem.boxes else [
                    fcl.CollisionObject(mesh, fcl.Transform(there[name][:3, :3], there[name][:3, 3]))
                    for mesh in _meshes(checker.arm.model.path, name)
                ]
                for name in (contact.a, contact.b)
            ]  # fmt: skip
            if any(
                fcl.collide(one, other, fcl.CollisionRequest(), fcl.CollisionResult())
                for one, other in itertools.product(*sides)
            ):
                return True
    return False


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
            body.addSubModel(move_points(vertices, origin_of(element, "collision")), faces)
            body.endModel()
            found.append(body)
    return found


def _solid(solid: Solid) -> Any:
    import fcl

    made = {"box": fcl.Box, "cylinder": lambda length, radius: fcl.Cylinder(radius, length)}
    return fcl.CollisionObject(
        made.get(solid.kind, fcl.Sphere)(*solid.size), fcl.Transform(solid.pose[:3, :3], solid.pose[:3, 3])
    )
