import io
import json
from pathlib import Path

import numpy as np
import pytest
from moving import at
from on_table import table

from topple.robots.shapes.boxes import box

BASE = ("--base", "-0.5", "0", "0", "0")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A block on a block on a table; the blocks are called 1 and 2."""
    rng = np.random.default_rng(0)
    clouds = {
        "table": table(0.3),
        "1": box("1", (0.05, 0.05, 0.05)).surface(3000, rng),
        "2": box("2", (0.05, 0.05, 0.05)).surface(3000, rng) + np.array([0.0, 0.0, 0.0505]),
    }
    np.savez(tmp_path / "scene.npz", **clouds)
    return tmp_path / "scene.npz"


def down(z: float, x: float = 0.0) -> np.ndarray:
    """The pose of Contact-GraspNet's hand that comes from above, its pads at a height."""
    turned = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turned, [x, 0.0, z + 0.1034]
    return pose


@pytest.fixture
def grasps(tmp_path: Path) -> Path:
    """What Contact-GraspNet writes: dicts by segment."""
    np.savez(
        tmp_path / "predictions.npz",
        pred_grasps_cam=np.array(
            {1.0: np.array([down(0.03)]), 2.0: np.array([down(0.088), down(0.088, 0.2)])}, dtype=object
        ),
        scores=np.array({1.0: np.array([0.9]), 2.0: np.array([0.4, 0.8])}, dtype=object),
        gripper_openings=np.array({1.0: np.array([0.07]), 2.0: np.array([0.06, 0.06])}, dtype=object),
    )
    return tmp_path / "predictions.npz"


def test_the_document_ranks_what_may_go_first_and_says_why_not(scene, grasps, typed):
    document = typed("rank", scene, grasps, "--robot", "panda", *BASE, "--json").document
    assert (document["format"], document["format_version"], document["robot"]) == ("topple.rank", 1, "panda")
    assert document["reach_asked"] is True
    entries = document["grasps"]
    told = [(entry["rank"], entry["index"], entry["object"]) for entry in entries]
    assert told == [(1, 1, "2"), (2, 0, "1"), (3, 2, None)]
    assert [entry["feasible"] for entry in entries] == [True, False, False]
    assert entries[0]["why"] is None
    assert "2 would move: has to go before 1" in entries[1]["why"]
    assert entries[1]["before"] == ["2"]
    assert entries[2]["why"] == "nothing is between its pads"
    assert entries[0]["width"] == 0.06
    assert entries[0]["score"] == 0.4
    assert np.allclose(np.array(entries[0]["pose_tool_to_world"])[:3, 3], [0.0, 0.0, 0.088])


def test_the_table_says_it_of_each_grasp(scene, grasps, typed):
    printed = typed("rank", scene, grasps).out
    assert "1 of 3 grasps can be done now" in printed
    assert "nothing is between its pads" in printed
    assert "Reach was not asked" in printed
    printed = typed("rank", "--fixed", "table", scene, grasps, "--target", "1").out
    assert "0 of 1 grasps can be done now" in printed


def test_grasps_out_of_reach_say_so(scene, grasps, typed):
    document = typed("rank", scene, grasps, "--base", "-3", "0", "0", "0", "--json").document
    assert document["grasps"][0]["why"] == "out of reach"


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ((), "a scene and a file of grasps expected"),
        (("GRASPS", "GRASPS"), "a scene and a file of grasps expected"),
        (("GRASPS", "--target", "cup"), "unknown target 'cup'"),
        (("GRASPS", "--robot", "hal"), "hal"),
        (("missing.npz",), "cannot be read"),
        (("SCENE",), "expected pred_grasps_cam or poses"),
        (("FAR",), "no grasp is near anything"),
    ],
)
def test_wrong_use_is_one_line(scene, grasps, argv, words, typed):
    far = at(9.0, 0.0, 0.0)
    np.save(scene.with_name("far.npy"), far[None])
    files = {"GRASPS": grasps, "SCENE": scene, "FAR": scene.with_name("far.npy")}
    printed = typed("rank", scene, *(str(files.get(word, word)) for word in argv), code=2)
    assert printed.out == ""
    assert words in printed.err
    assert printed.err.count("\n") == 1


def test_pairs_of_scenes_and_grasps_are_a_line_each_and_one_that_fails_stops_no_other(scene, grasps, typed):
    again = scene.with_name("again.npz")
    again.write_bytes(scene.read_bytes())
    pairs = typed("rank", scene, grasps, again, grasps, "--json").out
    first, second = (json.loads(line) for line in pairs.splitlines())
    assert (first["scene"], second["scene"]) == (str(scene), str(again))
    assert first["grasps"] == second["grasps"]
    printed = typed("rank", scene, "missing.npy", again, grasps, "--json", code=2)
    assert json.loads(printed.out)["scene"] == str(again)
    assert "missing.npy" in printed.err and printed.err.count("\n") == 1


@pytest.mark.parametrize("kind", ["npz", "npy"])
def test_grasps_are_piped_in(scene, grasps, kind, typed, monkeypatch):
    if kind == "npy":
        grasps = scene.with_name("poses.npy")
        np.save(grasps, np.array([np.diag([1.0, -1.0, -1.0, 1.0]) + np.eye(4, k=3) * 0.0]))
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(grasps.read_bytes())))
    piped = typed("rank", scene, "-", "--json").document
    direct = typed("rank", scene, grasps, "--json").document
    assert piped["grasps"] == direct["grasps"] and len(piped["grasps"]) > 0 and piped["file"] == "-"
