import hashlib
import json
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import networkx as nx
import numpy as np
import pytest
from on_table import BASE, on_table

from topple.planner.decide.goal import Goal
from topple.planner.errors import NoSafePlan
from topple.planner.export import EXPORTERS, export
from topple.planner.export.pddl import domain_and_problem
from topple.planner.planning.next_step import GoalTask, StepChooser
from topple.planner.planning.order import check_known
from topple.planner.planning.plan import plan, plan_all
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_schema, plan_to_json
from topple.planner.planning.step import Chooser, Context, NextStep
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.workers import WorkerPool
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

ARM = robot("panda-suction")


def stacked() -> Scene:
    return on_table(
        (box("lower box", (0.06, 0.06, 0.06)), (0.0, 0.0, 0.0)),
        (box("upper", (0.05, 0.05, 0.05)), (0.0, 0.0, 0.0605)),
    )


@pytest.fixture(scope="module")
def found() -> Plan:
    return plan(stacked(), ["lower box"], ARM, pose_base_to_world=BASE)


def test_what_lies_on_top_is_removed_first(found):
    taken = [(step.object, step.action) for step in found.steps]
    assert taken == [("upper", "remove"), ("lower box", "free")]
    assert found.steps[1].after == [0]
    assert found.order == ["upper", "lower box"]
    assert any(edge.first == "upper" and edge.then == "lower box" for edge in found.dependencies)


@dataclass(frozen=True)
class Pinching(GoalTask):
    """Says the lower box to be 20 mm wide, `times` over: the check refutes that, whatever takes it."""

    times: int = 0

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        return PinchingChooser(situation, goal, context, self.times)


class PinchingChooser(StepChooser):
    def __init__(self, situation: Situation, goal: Goal, context: Context, times: int) -> None:
        super().__init__(situation, goal, context)
        self.times = times

    def choose(self) -> NextStep | None:
        step, refuted = super().choose(), self.context.avoid.get("lower box", ())
        assert len(refuted) == len(self.context.barred)
        if step is None or step.transfer.object == "upper" or len(refuted) == self.times:
            return step
        return replace(step, transfer=replace(step.transfer, grasp=replace(step.transfer.grasp, width=0.02)))


def test_from_a_step_that_its_check_refutes_on_a_plan_is_made_anew(found):
    lines = list[str]()
    there, goal = stacked().with_base(BASE), Pinching(["lower box"], 1)
    other = plan(there, goal, ARM, verify=True, progress=lines.append)
    assert other.verify(stacked()).ok
    assert sum("upper" in line for line in lines) == 1  # what went before stays
    first, second = found.steps[1], other.steps[1]
    assert other.steps[0].segments == found.steps[0].segments
    assert first.grasp.pose_tool_to_world != second.grasp.pose_tool_to_world
    assert first.placement.pose_before_to_after != second.placement.pose_before_to_after


@pytest.mark.slow
def test_where_the_check_refutes_plan_after_plan_its_first_reason_is_told():
    with pytest.raises(NoSafePlan, match="own check: grasps that hold nothing"):
        plan(stacked(), Pinching(["lower box"], 9), ARM, pose_base_to_world=BASE, verify=True)


@pytest.mark.slow
def test_many_scenes_are_planned_one_by_one_and_a_lack_of_plan_is_said(found, tmp_path):
    far = BASE.copy()
    far[0, 3] = -5.0
    for name, base in (("near", BASE), ("far", far)):
        np.savez(tmp_path / f"{name}.npz", **stacked().clouds, fixed=["table"], up=[0, 0, 1], robot_base=base)
    with WorkerPool(1) as pool:
        paths = [tmp_path / "near.npz", tmp_path / "far.npz"]
        near, none = plan_all(paths, ["lower box"], "panda-suction", executor=pool)
    assert isinstance(near, Plan) and near.steps[0].segments == found.steps[0].segments
    assert isinstance(none, NoSafePlan) and none.certificate


def test_each_step_starts_where_the_last_one_ended(found):
    q = np.array(found.q_start)
    assert [sum(segment.motion is not None for segment in step.segments) for step in found.steps] == [6, 6]
    for step in found.steps:
        for segment in step.segments:
            if segment.motion is not None:
                assert np.abs(np.array(segment.motion.positions[0]) - q).max() < 1e-4
                q = np.array(segment.motion.positions[-1])


def test_a_plan_is_read_back_equal(found):
    assert plan_from_json(plan_to_json(found)) == found


def test_the_published_schema_is_that_of_the_structs():
    published = Path(__file__).resolve().parents[3] / "docs" / "plan.schema.json"
    assert json.loads(published.read_text()) == json.loads(json.dumps(plan_schema())), "run `make schema`"


def test_every_motion_is_proven_and_says_what_may_touch(found):
    assert found.certified
    for step in found.steps:
        moving = [segment for segment in step.segments if segment.motion is not None]
        assert all(segment.certified and segment.clearance > 0 for segment in moving)
        assert not next(segment for segment in moving if segment.kind == "move").may_touch
        assert step.attachments[0].object == step.object
    assert found.planning_seconds >= sum(step.planning_seconds for step in found.steps) - 0.01


@pytest.mark.parametrize(
    ("path", "value", "where"),
    [
        (("steps", 0, "grasp", "width"), "wide", r"\$.steps\[0\].grasp.width"),
        (("steps", 1, "after"), [7], r"\$.steps\[1\].after\[0\]"),
        (("pose_base_to_world",), [[1.0]], r"\$.pose_base_to_world"),
        (("q_start",), [0.0], r"\$.q_start"),
        (
            ("steps", 0, "segments", 0, "motion", "positions", 0),
            [0.0],
            r"rows of one length - at `\$.steps\[0\].segments\[0\].motion.positions`",
        ),
        (("steps", 0, "segments", 0, "motion", "times"), "soon", r"segments\[0\].motion.times"),
        (("format",), "topple.order", r"\$.format"),
        (
            ("pose_base_to_world",),
            np.diag([1.0, -1.0, 1.0, 1.0]).tolist(),
            r"`\$.pose_base_to_world` is mirrored",
        ),
        (("arm", "tools", 0, "pose_tool_to_link"), [[0.0] * 4] * 4, r"\$.arm.tools\[0\].pose_tool_to_link"),
        (("objects", 1, "name"), "table", r"`\$.objects` has a name twice"),
        (("objects", 1, "parts"), [], r"`\$.objects\[1\].parts` is empty"),
    ],
)
def test_a_corrupted_plan_is_refused_with_the_path_of_the_field(found, path, value, where):
    document = json.loads(plan_to_json(found))
    here = document
    for key in path[:-1]:
        here = here[key]
    here[path[-1]] = value
    with pytest.raises(InvalidInput, match=where):
        plan_from_json(json.dumps(document))


def test_what_is_no_json_is_refused():
    with pytest.raises(InvalidInput, match="not JSON"):
        plan_from_json(b"{")


def test_out_of_reach_is_no_plan_with_a_certificate():
    far = BASE.copy()
    far[0, 3] = -3.0
    with pytest.raises(NoSafePlan) as caught:
        plan(stacked(), ["upper"], ARM, pose_base_to_world=far)
    assert "upper" in caught.value.certificate[0]


def test_an_unknown_target_is_named():
    with pytest.raises(UnknownObject, match="cup"):
        plan(stacked(), ["cup"], ARM, pose_base_to_world=BASE)


def test_every_export_is_text(found):
    for name in EXPORTERS:
        assert export(found, name).strip()
    with pytest.raises(InvalidInput, match="pddl"):
        export(found, "word")


def test_graphs_have_the_precedence_of_the_steps(found):
    graph = nx.parse_graphml(export(found, "graphml"))
    assert list(graph.edges) == [("1 upper", "2 lower box")]
    assert '"1 upper" -> "2 lower box"' in export(found, "dot")


def test_the_tree_is_well_formed_and_its_actions_are_declared(found):
    root = ElementTree.fromstring(export(found, "bt").encode())
    assert root.get("BTCPP_format") == "4"
    declared = {node.get("ID") for node in root.find("TreeNodesModel") or []}
    used = {node.get("ID") for node in (root.find("BehaviorTree") or root).iter("Action")}
    assert used
    assert used <= declared


def test_pddl_lets_nothing_be_taken_before_what_lies_on_it(found):
    domain, problem = domain_and_problem(found)
    for text in (domain, problem):
        assert text.count("(") == text.count(")")
    take = domain[domain.index("take-o-lower-box") :]
    assert "(put-down o-upper)" in take[: take.index(":effect")]
    assert "(put-down o-lower-box)" in problem


def test_a_moveit_scene_lists_every_object_with_its_meshes(found):
    lines = export(found, "moveit").splitlines()
    assert [line[2:] for line in lines if line.startswith("* ")] == ["table", "lower box", "upper"]
    assert lines[-1] == "."
    start = lines.index("mesh")
    vertices, faces = map(int, lines[start + 1].split())
    rows = [line.split() for line in lines[start + 2 : start + 2 + vertices + faces]]
    assert all(len(row) == 3 for row in rows)


def test_plans_are_frozen(found):
    with pytest.raises(AttributeError):
        found.seed = 1  # type: ignore[misc]
    assert isinstance(found, msgspec.Struct)


def test_the_plan_says_with_which_arm_and_tool_and_where_its_urdf_is(found):
    arm = found.arm
    assert arm is not None
    assert (arm.urdf, arm.catalog) == ("pybullet_data:franka_panda/panda.urdf", True)
    known = robot(found.robot)
    assert arm.sha256 == hashlib.sha256(known.source.read_bytes()).hexdigest()
    assert arm.joints == found.joints and arm.upper == known.upper.tolist()
    tools = {tool.name: tool for tool in arm.tools}
    jaw, cup = tools["fingers"].jaw, tools["suction"].cup
    assert jaw is not None and cup is not None
    assert (jaw.openings, jaw.joint_values) == ([0.0, 0.08], [[0.0, 0.0], [0.04, 0.04]])
    assert (cup.link, cup.radius) == ("suction_cup", 0.015)
    for step in found.steps:  # a controller finds the grasp with what is written
        approach = next(segment for segment in step.segments if segment.kind == "approach")
        assert approach.motion is not None
        tool = tools[approach.tool]
        link = known.forward(np.array(approach.motion.positions[-1]))[0, known.links.index(tool.link)]
        at = np.array(found.pose_base_to_world) @ link @ np.array(tool.pose_tool_to_link)
        assert np.abs(at - np.array(step.grasp.pose_tool_to_world)).max() < 1e-3


def test_a_plan_without_the_arms_data_is_still_read_and_checked(found):
    document = json.loads(plan_to_json(found))
    del document["arm"]
    old = plan_from_json(json.dumps(document))
    assert old.arm is None
    assert old.verify()["tool at the grasp"] <= 0.0


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"sha256": "0" * 64}, "is not the file the plan was made with"),
        ({"urdf": "/no/arm.urdf"}, "described by /no/arm.urdf, which is not here"),
        ({"urdf": "no_such_package:arm.urdf"}, "described by no_such_package:arm.urdf, which is not here"),
    ],
)
def test_another_urdf_than_the_plans_is_refused_in_one_line(found, changed, words):
    document = json.loads(plan_to_json(found))
    document["arm"].update(changed)
    with pytest.raises(InvalidInput, match=words):
        plan_from_json(json.dumps(document)).verify()


def test_a_motion_is_given_as_arrays_by_number_and_by_name(found):
    times, positions, velocities = found.trajectory(0, "approach")
    assert times.shape == (len(times),) and times[0] == 0.0 and (np.diff(times) > 0).all()
    assert not any(each.flags.writeable for each in (times, positions, velocities))
    assert positions.shape == velocities.shape == (len(times), len(found.joints))
    motion = found.steps[0].segments[1].motion
    assert motion is not None and np.array_equal(positions, motion.positions)
    assert np.array_equal(found.trajectory(0, 1).velocities, motion.velocities)


@pytest.mark.parametrize(
    ("step", "segment", "words"),
    [
        (9, 0, "the plan has no step 9: expected 0 to"),
        (-1, 0, "the plan has no step -1"),
        (0, 8, "step 0 has no segment 8: it has 0 move, 1 approach, 2 grasp"),
        (0, -1, "has no segment -1"),
        (0, "fly", "has no segment 'fly'"),
        (0, "grasp", "the arm stands still in segment 2, grasp"),
    ],
)
def test_a_motion_that_is_not_there_is_refused(found, step, segment, words):
    with pytest.raises(InvalidInput, match=words):
        found.trajectory(step, segment)


@pytest.mark.parametrize("base", [[-0.5, 0.0, 0.0], np.diag([1.0, -1.0, 1.0, 1.0]), np.full((4, 4), np.nan)])
def test_a_base_that_is_no_pose_is_refused(base):
    with pytest.raises(InvalidInput, match=r"^base "):
        plan(stacked(), ["upper"], ARM, pose_base_to_world=base)  # type: ignore[arg-type]


def test_a_single_name_may_be_kept_upright():
    assert check_known("upper", stacked(), ("upper",)) == {"upper"}
    with pytest.raises(UnknownObject, match="'glass'"):
        check_known("glass", stacked(), ("upper",))


def test_beside_what_is_no_more_than_a_line_a_plan_is_checked_and_handed_on():
    thread = np.linspace([0.0, 0.3, 0.001], [0.05, 0.3, 0.001], 50)
    made = plan(stacked().with_cloud("thread", thread), ["upper"], ARM, pose_base_to_world=BASE)
    assert made.order == ["upper"] and "thread" in export(made, "moveit")
