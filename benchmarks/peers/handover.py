"""Problems as files any planner can read: the arm as a URDF with convex meshes, the rest as JSON."""

import json
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from topple.benchmarks.motion_problems import Problem
from topple.robots.arm.arm import Arm
from topple.robots.collision.convex import hull_of
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray


def handed_over(folder: Path, problems: Sequence[Problem], seed: int, budget: float) -> None:
    """Write `arm.urdf`, `arm.srdf` and `problems.json`.

    The arm has the collision parts, joint limits and self-collision pairs of ours, its hand fixed open.

    Args:
        folder: An empty folder.
        problems: All with the same arm.
        seed: Handed on.
        budget: Seconds for one problem, handed on.
    """
    arm = problems[0].checker.arm
    _write_arm(folder, arm)
    checked = {frozenset((arm.links[i], arm.links[j])) for i, j in arm.self_pairs}
    ignored = [pair for pair in combinations(arm.links, 2) if frozenset(pair) not in checked]
    lines = [f'<disable_collisions link1="{a}" link2="{b}" reason="never"/>' for a, b in ignored]
    (folder / "arm.srdf").write_text(f'<robot name="arm">{"".join(lines)}</robot>', encoding="utf-8")
    document = {
        "seed": seed,
        "budget": budget,
        "links": arm.links,
        "joints": arm.joints,
        "ignored_pairs": ignored,
        "problems": [_as_json(problem) for problem in problems],
    }
    (folder / "problems.json").write_text(json.dumps(document), encoding="utf-8")


def _as_json(problem: Problem) -> dict[str, object]:
    boxes = [
        {
            "name": name, "kind": solid.kind, "size": [*solid.size], "pose": solid.pose.tolist(),
            "centre": solid.pose[:3, 3].tolist(),
            "yaw": float(np.arctan2(solid.pose[1, 0], solid.pose[0, 0])),
        }
        for name, solid in problem.boxes.items()
    ]  # fmt: skip
    return {"boxes": boxes, "start": problem.start.tolist(), "goals": problem.goals.tolist()}


def _write_arm(folder: Path, arm: Arm) -> None:
    offsets = dict(zip(arm.links, arm.offsets(arm.open_hand), strict=True))
    driven = {name: k for k, name in enumerate(arm.joints)}
    lines = ['<robot name="arm">']
    for link, parts in zip(arm.links, arm.parts, strict=True):
        shape = "".join(_collision(folder / f"{link}_{k}.obj", part) for k, part in enumerate(parts))
        lines.append(f'<link name="{link}">{_INERTIA}{shape}</link>')
    for joint in arm.model.joints.values():
        ends = f'<parent link="{joint.parent}"/><child link="{joint.child}"/>'
        k = driven.get(joint.name)
        if k is None:  # the hand stands still: both ends move with the same frame
            pose = inverse(offsets[joint.parent]) @ offsets[joint.child]
            lines.append(f'<joint name="{joint.name}" type="fixed">{ends}{_origin(pose)}</joint>')
            continue
        limit = f'lower="{arm.lower[k]}" upper="{arm.upper[k]}" velocity="{arm.velocity[k]}" effort="100"'
        axis = " ".join(str(float(v)) for v in joint.axis)
        origin = _origin(joint.pose_child_to_parent)
        kind = "prismatic" if joint.kind == "prismatic" else "revolute"
        inside = f'{ends}{origin}<axis xyz="{axis}"/><limit {limit}/>'
        lines.append(f'<joint name="{joint.name}" type="{kind}">{inside}</joint>')
    (folder / "arm.urdf").write_text("\n".join([*lines, "</robot>"]), encoding="utf-8")


_INERTIA = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def _collision(path: Path, hull: FloatArray) -> str:
    vertices, triangles = hull_of(hull)
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    # where mplib is told that meshes are convex, it looks for them under this name
    trimesh.Trimesh(vertices, triangles, process=False).export(path.with_name(f"{path.name}.convex.stl"))
    return f'<collision><geometry><mesh filename="{path.name}"/></geometry></collision>'


def _origin(pose: FloatArray) -> str:
    turn = Rotation.from_matrix(pose[:3, :3]).as_euler("xyz")
    xyz, rpy = (" ".join(f"{v:.12g}" for v in np.asarray(values)) for values in (pose[:3, 3], turn))
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'
