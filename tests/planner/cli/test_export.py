"""`topple export`: a real plan in every format, read back by other programs' parsers, and the refusals."""

import io
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from topple.planner.cli.main import main
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import plan_from_json, plan_to_json
from topple.robots.catalog import robot
from topple.topology.scene.scene import Scene


def _cube(size: float, height: float) -> np.ndarray:
    """Surface points of a cube that stands on a height."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-size / 2, size / 2, (1500, 3))
    points[np.arange(1500), rng.integers(3, size=1500)] = rng.choice([-size / 2, size / 2], 1500)
    return points + np.array([0, 0, height + size / 2])


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plan that frees a cube under another one."""
    table = np.random.default_rng(0).uniform(-0.6, 0.6, (5000, 3)) * [1, 1, 0]
    clouds = {"table": table, "under it": _cube(0.05, 0.0), "on top": _cube(0.04, 0.0505)}
    base = np.eye(4)
    base[0, 3] = -0.5
    scene = Scene(clouds, fixed=["table"], up=(0, 0, 1), robot_base=base)
    found = plan(scene, ["under it"], robot("panda"))
    place = tmp_path_factory.mktemp("plan") / "plan.json"
    place.write_bytes(plan_to_json(found))
    return place


def test_dot_has_the_edge(plan_file, typed):
    text = typed("export", plan_file, "--to", "dot").out
    assert text.startswith("digraph plan {")
    assert '"1 on top" -> "2 under it"' in text


def test_graphml_is_read_by_networkx(plan_file, typed):
    graph = nx.parse_graphml(typed("export", plan_file, "--to", "graphml").out)
    assert list(graph.edges) == [("1 on top", "2 under it")]


def test_the_tree_has_a_branch_for_each_step(plan_file, typed):
    root = ElementTree.fromstring(typed("export", plan_file, "--to", "bt").out.encode())
    assert root.get("BTCPP_format") == "4"
    branches = root.findall("./BehaviorTree/Sequence/Sequence")
    assert [branch.get("name") for branch in branches] == ["remove on top", "free under it"]
    modelled = {node.get("ID") for node in root.findall("./TreeNodesModel/Action")}
    assert {node.get("ID") for node in root.iter("Action")} == modelled


def test_the_moveit_scene_has_every_object(plan_file, typed):
    lines = typed("export", plan_file, "--to", "moveit").out.splitlines()
    assert [line[2:] for line in lines if line.startswith("* ")] == ["table", "under it", "on top"]
    assert lines[-1] == "."


def test_a_recording_of_ros_2_does_what_the_plan_does(plan_file, tmp_path, capsys, typed):
    assert main(["export", str(plan_file), "--to", "ros2"]) == 2  # no text
    assert "ros2 is no text: say with -o FILE where it is written" in capsys.readouterr().err
    typed("export", plan_file, "--to", "ros2", "-o", tmp_path / "plan.mcap")
    found, sent = plan_from_json(plan_file.read_bytes()), dict[str, list]()
    with AnyReader([tmp_path / "plan.mcap"]) as reader:  # by the types that are in the file
        for connection, recorded, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            sent.setdefault(connection.topic, []).append((recorded / 1e9, connection.msgtype, message))
    assert {kind for _, kind, _ in sent["/joint_trajectory"]} == {"trajectory_msgs/msg/JointTrajectory"}
    motions = [part.motion for step in found.steps for part in step.segments if part.motion is not None]
    assert len(motions) == len(sent["/joint_trajectory"]) > 8
    clock = 0.0
    for motion, (recorded, _, message) in zip(motions, sent["/joint_trajectory"], strict=True):
        assert recorded >= clock and message.header.frame_id == "base"  # one after the other
        clock = recorded + motion.times[-1] - 1e-6
        assert message.joint_names == found.joints
        for sent_rows, rows in (("positions", motion.positions), ("velocities", motion.velocities)):
            assert np.array_equal([getattr(point, sent_rows) for point in message.points], rows)
        told = [at.time_from_start.sec + 1e-9 * at.time_from_start.nanosec for at in message.points]
        assert told == pytest.approx(motion.times, abs=1e-8)
    opened = [message.position for _, _, message in sent["/gripper_command"]]
    hands = [part.hand.opening for step in found.steps for part in step.segments]
    assert opened == [hand for hand, before in zip(hands, [None, *hands], strict=False) if hand != before]
    segments = [json.loads(message.data) for _, _, message in sent["/topple/segment"]]
    assert [each["kind"] for each in segments] == [s.kind for step in found.steps for s in step.segments]
    assert json.loads(sent["/topple/order"][0][2].data)["order"] == found.order
    objects = {message.id: message for _, _, message in sent["/collision_object"]}
    assert set(objects) == {"table", "under it", "on top"}
    corners = np.array([[at.x, at.y, at.z] for at in objects["on top"].meshes[0].vertices])
    assert corners.min(axis=0) == pytest.approx([-0.02, -0.02, 0.0505], abs=3e-3)
    assert corners.max(axis=0) == pytest.approx([0.02, 0.02, 0.0905], abs=3e-3)
    triangles = np.array([face.vertex_indices for face in objects["on top"].meshes[0].triangles])
    assert triangles.shape[1] == 3 and triangles.max() == len(corners) - 1
    (placed,) = sent["/tf_static"][0][2].transforms
    assert (placed.header.frame_id, placed.child_frame_id) == ("world", "base")
    assert placed.transform.translation.x == pytest.approx(-0.5)


def test_pddl_goes_to_one_file_or_two(plan_file, typed):
    both = typed("export", plan_file, "--to", "pddl").out
    assert both.count("(define") == 2
    assert both.count("(") == both.count(")")
    typed("export", plan_file, "--to", "pddl", "-o", plan_file.parent)
    domain, problem = ((plan_file.parent / f"{name}.pddl").read_text() for name in ("domain", "problem"))
    assert domain.count("(define (domain") == 1
    assert problem.count("(define (problem") == 1
    assert f"{domain}\n;; problem\n{problem}".strip() == both.strip()


def test_a_file_is_written_and_said(plan_file, typed):
    place = plan_file.parent / "tree.xml"
    assert str(place) in typed("export", plan_file, "--to", "bt", "-o", place).out
    assert place.read_text() == typed("export", plan_file, "--to", "bt").out


def test_json_holds_the_text(plan_file, typed):
    document = typed("export", plan_file, "--to", "dot", "--json").document
    assert document["format"] == "topple.export"
    assert document["to"] == "dot"
    assert document["text"] == typed("export", plan_file, "--to", "dot").out


def test_a_plan_may_come_through_a_pipe(plan_file, typed, monkeypatch):
    expected = typed("export", plan_file, "--to", "dot").out
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(plan_file.read_bytes())))
    assert typed("export", "-", "--to", "dot").out == expected


@pytest.mark.parametrize(
    ("where", "value", "words"),
    [
        (("robot",), 7, "$.robot"),
        (("format",), "other", "$.format"),
        (("steps", 0, "grasp", "width"), "wide", "$.steps[0].grasp.width"),
        (("steps", 1, "after"), [5], "$.steps[1].after[0]"),
        (("steps", 0, "segments", 1, "kind"), "dance", "$.steps[0].segments[1].kind"),
        (("objects", 1, "parts", 0, 0), [1.0], "$.objects[1].parts[0][0]"),
        (("pose_base_to_world",), [[1.0]], "$.pose_base_to_world"),
    ],
)
def test_a_bad_field_is_named(plan_file, tmp_path, typed, where, value, words):
    document = json.loads(plan_file.read_bytes())
    inner = document
    for key in where[:-1]:
        inner = inner[key]
    inner[where[-1]] = value
    broken = tmp_path / "broken.json"
    broken.write_text(json.dumps(document))
    for to in ("moveit", "bt"):
        out, err = typed("export", broken, "--to", to, code=2)
        assert out == ""
        assert words in err
        assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "not JSON"), (b"\xff\xfe{", "not JSON"), (b"[1, 2]", "no plan"), (b"{}", "goal")],
)
def test_what_is_no_plan_is_refused(tmp_path, typed, content, words):
    (tmp_path / "plan.json").write_bytes(content)
    assert words in typed("export", tmp_path / "plan.json", "--to", "dot", code=2).err


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--to", "png"], "expected dot"),
        (["--to", "dot", "-o", "no/such/folder/plan.dot"], "does not exist"),
        (["--to", "dot", "-o", "."], "it is a folder"),
        ([], "--to"),
    ],
)
def test_wrong_use_is_code_2(plan_file, typed, more, words):
    assert words in typed("export", plan_file, *more, code=2).err


def test_a_missing_plan_is_code_2(tmp_path, typed):
    assert "none.json" in typed("export", tmp_path / "none.json", "--to", "dot", code=2).err
