"""Every reader of topple, with a small sound input made here."""

import json
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from topple.benchmarks.episodes import Ending, Episode
from topple.benchmarks.fuzz.oracle import wrong_numbers
from topple.benchmarks.fuzz.reader import Parts, Reader
from topple.benchmarks.fuzz.recordings import RECORDINGS
from topple.benchmarks.fuzz.scenes import SCENES, cloud, npy
from topple.benchmarks.journal import Journal
from topple.benchmarks.versions import code_key
from topple.planner.decide.goal import Goal, parse_goal
from topple.planner.formats.plan_structs import (
    AttachmentData,
    DependencyData,
    GraspData,
    ObjectData,
    PlacementData,
    Step,
)
from topple.planner.grasp.foreign import ForeignGrasps, read_grasps
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.robots.arm.gripper import ToolState
from topple.robots.arm.gripper_file import read_gripper
from topple.robots.arm.urdf import Model, read_urdf
from topple.robots.driver import Trajectory
from topple.topology.io.limits import read_bytes
from topple.topology.io.strict_json import read_json
from topple.topology.relations.relate import Relations, relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

_POSE = np.eye(4).tolist()


@cache
def _pair() -> Scene:
    """Two boxes beside each other."""
    return Scene({"mug": cloud(), "box": cloud() + np.array([0.1, 0.0, 0.0])}, up=[0, 0, 1])


def _relations() -> Parts:
    return {"relations.json": json.dumps(relate(_pair()).to_json()).encode()}


def _read_relations(path: Path) -> Relations:
    return Relations.from_json(read_json(read_bytes(path, str(path)), str(path)), _pair())


def _wrong_relations(answer: object, path: Path) -> str | None:
    if not isinstance(answer, Relations):
        return "no relations"
    for pair in answer:
        if pair.relation not in Relation or pair.matrix.shape != (2, 3):
            return f"{pair.relation} with a matrix {pair.matrix.shape}"
        told: Any = (pair.reason, pair.kind)
        if not all(isinstance(one, (str, NoneType)) for one in told):
            return f"the reason {told}"
        if not 0.0 <= pair.confidence <= 1.0:
            return f"a confidence of {pair.confidence}"
    return wrong_numbers(answer.to_json())


def _plan() -> Parts:
    motion = Trajectory(np.arange(2.0), np.array([[0.0, 0.1], [0.2, 0.1]]), np.zeros((2, 2)))
    hand = ToolState(0.08, 0.0)
    segments = [
        Segment(SegmentKind.APPROACH, "fingers", hand, motion, certified=True, clearance=0.02),
        Segment(SegmentKind.GRASP, "fingers", hand, may_touch=(("finger", "mug"),)),
    ]
    step = Step(
        object="mug", action="free", reason="asked for", after=[],
        grasp=GraspData("pinch", _POSE, 0.05, 0.9, terms={"depth": 0.5}),
        placement=PlacementData(_POSE, into="box", how="on"),
        segments=segments, attachments=[AttachmentData("mug", "fingers", _POSE)],
        against=[DependencyData("box", "mug", "leaning", 0.3)],
    )  # fmt: skip
    plan = Plan(
        goal="free mug", robot="panda", joints=["a", "b"], seed=0, pose_base_to_world=_POSE,
        base_searched=False, q_start=[0.0, 0.1], order=["mug"], dependencies=[], steps=[step],
        objects=[ObjectData("mug", False, [cloud(4).tolist()]), ObjectData("box", True, [cloud(4).tolist()])],
    )  # fmt: skip
    return {"plan.json": plan_to_json(plan)}


def _wrong_plan(answer: object, path: Path) -> str | None:
    if not isinstance(answer, Plan) or plan_from_json(plan_to_json(answer)) != answer:
        return "a plan that is not read back equal"
    return wrong_numbers(answer)


def _poses() -> Parts:
    return {"grasps.npy": npy(np.tile(np.eye(4), (3, 1, 1)))}


def _graspnet() -> Parts:
    return {
        "grasps.npy": npy(np.array([[0.8, 0.06, 0.02, 0.03, *np.eye(3).ravel(), 0.1, 0.2, 0.5, 5.0]] * 3))
    }


def _contact_graspnet() -> Parts:
    hands = np.tile(np.eye(4), (2, 1, 1))
    stored = {"pred_grasps_cam": hands, "scores": np.ones(2), "gripper_openings": np.full(2, 0.04)}
    return {f"{name}.npy": npy({1: one}) for name, one in stored.items()}


def _yaml() -> Parts:
    entry = "    confidence: 0.7\n    position: [0.1, 0.0, 0.0]\n"
    entry += "    orientation: {w: 1.0, xyz: [0.0, 0.0, 0.0]}\n"
    return {"grasps.yaml": f"format: isaac_grasp\nformat_version: 1.0\ngrasps:\n  one:\n{entry}".encode()}


def _wrong_grasps(answer: object, path: Path) -> str | None:
    if not isinstance(answer, ForeignGrasps):
        return "no grasps"
    count = len(answer)
    if answer.poses_tool_to_source.shape != (count, 4, 4) or answer.widths.shape != (count,):
        return f"{count} grasps with poses {answer.poses_tool_to_source.shape}"
    return wrong_numbers([answer.poses_tool_to_source, answer.scores])


def _gripper() -> Parts:
    text = (
        '[jaw]\njoints = ["left", "right"]\nlinks = ["a", "b"]\nlink = "hand"\noffset = [0.0, 0.0, 0.1]\n'
        "closed = [0.0, 0.0]\nopen = [0.04, 0.04]\nopening = [0.0, 0.08]\npads = [0.02, 0.018]\n"
        "force = 70.0\n"
        '[cup]\nlink = "flange"\noffset = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]\nradius = 0.015\nforce = 20.0\n'
    )
    return {"gripper.toml": text.encode()}


def _urdf() -> Parts:
    shapes = (
        '<box size="0.1 0.1 0.1"/>',
        '<cylinder radius="0.05" length="0.2"/>',
        '<sphere radius="0.05"/>',
    )
    text = '<robot name="arm">\n'
    for number, shape in enumerate(shapes):
        text += f'<link name="l{number}"><collision><origin xyz="0 0 0.1" rpy="0 0 0"/><geometry>{shape}'
        text += "</geometry></collision></link>\n"
    for number in (1, 2):
        text += (
            f'<joint name="j{number}" type="revolute"><parent link="l{number - 1}"/><child link="l{number}"/>'
        )
        text += '<origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>'
        text += '<limit lower="-2.6" upper="2.6" velocity="2" effort="10"/></joint>\n'
    return {"arm.urdf": (text + "</robot>\n").encode()}


def _wrong_urdf(answer: object, path: Path) -> str | None:
    if not isinstance(answer, Model):
        return "no arm"
    if any(part.ndim != 2 or part.shape[1] != 3 for link in answer.links.values() for part in link.parts):
        return "a part that is no points"
    return wrong_numbers([[link.parts for link in answer.links.values()], list(answer.joints.values())])


def _journal() -> Parts:
    ending = Ending(Episode("pile", 3), "success", seconds=31.5, sagged=0.001).to_json()
    line = json.dumps({**ending, "commit": "a2ac90c", "code": code_key()})
    return {"endings.jsonl": f"{line}\n{line}\n".encode()}


def _read_journal(path: Path) -> list[Ending]:
    return [Ending.from_json(entry) for entry in Journal(path).entries]


def _goal() -> Parts:
    return {"goal.txt": b"mug on box, empty box"}


def _read_goal(path: Path) -> Goal:
    return parse_goal(read_bytes(path, "it").decode("utf-8", "replace"), _pair())


READERS = (
    *SCENES,
    *RECORDINGS,
    Reader("relations json", _relations, _read_relations, _wrong_relations, "relations.json"),
    Reader("plan json", _plan, lambda path: plan_from_json(read_bytes(path, "it")), _wrong_plan, "plan.json"),
    Reader("grasps, poses", _poses, read_grasps, _wrong_grasps, "grasps.npy"),
    Reader("grasps, graspnet", _graspnet, read_grasps, _wrong_grasps, "grasps.npy"),
    Reader("grasps, segments", _contact_graspnet, read_grasps, _wrong_grasps, "grasps.npz", packed=True),
    Reader("grasps, isaac", _yaml, read_grasps, _wrong_grasps, "grasps.yaml"),
    Reader("gripper toml", _gripper, read_gripper, wrong_numbers, "gripper.toml"),
    Reader("urdf", _urdf, read_urdf, _wrong_urdf, "arm.urdf"),
    Reader("journal", _journal, _read_journal, wrong_numbers, "endings.jsonl"),
    Reader("goal", _goal, _read_goal, wrong_numbers, "goal.txt"),
)
"""All of them."""
