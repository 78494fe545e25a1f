import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from topple.topology import load_scene

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
FRAMES = EXAMPLES.parents[1] / "shared" / "data" / "rgbd"
SCRIPTS = tuple(sorted(path.name for path in EXAMPLES.glob("*.py")))
PAGE = (EXAMPLES.parent / "docs" / "examples.md").read_text(encoding="utf-8")
ON_BULLET = {"09_own_world.py"}  # a foreign world of PyBullet, or of MuJoCo where that alone is


def _output(folder: Path, script: str, *arguments: str) -> list[str]:
    """Lines an example prints; its warnings are errors."""
    there = {"OMP_NUM_THREADS": "1", "PYTHONPATH": f"{folder}:{os.environ.get('PYTHONPATH', '')}"}
    argv = [sys.executable, "-W", "error", str(EXAMPLES / script), *arguments]
    kept = {"cwd": folder, "env": os.environ | there, "capture_output": True, "text": True, "timeout": 240}
    done = subprocess.run(argv, **kept)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()


def test_every_example_is_tested_and_short():
    tested = Path(__file__).read_text(encoding="utf-8")
    assert all(f'_output(tmp_path, "{script}"' in tested for script in SCRIPTS) and len(SCRIPTS) == 13
    assert tuple(re.findall(r"^\| `(\w+\.py)` \|", PAGE, re.MULTILINE)) == SCRIPTS
    for script in SCRIPTS:
        most = 90 if "mujoco" in script else 60  # two protocols are written there
        assert len((EXAMPLES / script).read_text(encoding="utf-8").splitlines()) < most, script


def test_examples_name_no_engine_but_those_that_need_it():
    bound = r"pybullet|bullet|SimulatedArm|\bWorld\b|scene_from_world|\.verify\("
    texts = {script: (EXAMPLES / script).read_text(encoding="utf-8") for script in SCRIPTS}
    assert {script for script, text in texts.items() if re.search(bound, text)} == ON_BULLET


@pytest.mark.slow
@pytest.mark.parametrize("script", [each for each in SCRIPTS if re.search("hold|learn|own|bop", each)])
def test_examples_play_where_mujoco_alone_is(script, tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "sitecustomize.py").write_text("import sys; sys.modules['pybullet'] = None", encoding="utf-8")
    assert _output(tmp_path, script)


@pytest.mark.slow
def test_a_loop_of_ones_own_builds_a_tower_and_moves_nothing_else(tmp_path):
    lines = _output(tmp_path, "08_own_loop.py")
    steps = [line.split(":")[0] for line in lines if not line.startswith(("seen", "in truth"))]
    assert steps == ["remove red", "place green", "place red"]
    assert lines.count("seen: everything is where it should be") == 3
    assert float(lines[-1].split()[-2]) < 1.0


@pytest.mark.slow
def test_a_policy_learns_and_is_held_against_the_highest_first(tmp_path):
    lines = _output(tmp_path, "11_learn.py")
    assert [line.split(":")[0] for line in lines] == ["8 scenes", "learned", "highest"]
    found = json.loads((tmp_path / "learned.json").read_text(encoding="utf-8"))
    assert len(found["returns"]) == 8 and len(found["learned"]) == len(found["highest"]) == 1
    # what is barred waits, what bars the target goes
    assert found["weights"][3] < 0 < found["weights"][2] and (tmp_path / "learned.png").exists()


@pytest.mark.slow
def test_two_things_change_places_by_a_verified_plan(tmp_path):
    lines = _output(tmp_path, "07_swap.py")
    assert lines[-1].startswith("3 moves, ") and lines[-1].endswith("certified: True")
    assert not any("not checked" in line for line in lines)
    assert len(_output(tmp_path, "07_swap.py", "start.npz", "goal.npz")) == 2
    assert load_scene(tmp_path / "start.npz").names == load_scene(tmp_path / "goal.npz").names


@pytest.mark.slow
def test_look_writes_a_small_scene_that_says_everything(tmp_path):
    assert _output(tmp_path, "01_look.py")
    scene = load_scene(tmp_path / "scene.npz")
    assert set(scene.names) == {"table", "plate", "spoon_1", "spoon_2", "fork", "can"}
    assert scene.fixed == {"table"}
    assert scene.up is not None and scene.up == pytest.approx([0, 0, 1])
    assert scene.viewpoints.shape == (3, 3)
    assert scene.robot_base is not None
    assert scene.assumptions == ()
    assert (tmp_path / "scene.npz").stat().st_size < 1_000_000


@pytest.mark.slow
def test_a_simulated_scene_becomes_one_of_a_bop_dataset(tmp_path):
    lines = _output(tmp_path, "02_write_bop.py")
    assert lines[-1].startswith("bop/test/000001: obj_000001 plate, ")
    scene = load_scene(tmp_path / "bop" / "test" / "000001", image=2)
    assert len(scene.names) == 6 and scene.fixed == {"table"}


@pytest.mark.slow
def test_a_simulated_camera_becomes_a_recording_of_ros(tmp_path):
    assert _output(tmp_path, "03_write_bag.py")[-1].startswith("run: labels 1 table 3 plate ")
    scene = load_scene(tmp_path / "run" / "run.mcap", fixed=["1"], image=2)
    assert len(scene.names) == 6 and scene.robot_base is not None


def test_a_ros_node_answers_a_cloud_as_it_comes_over_the_wire(tmp_path):
    told = json.loads(_output(tmp_path, "04_ros_node.py")[-1])
    assert told["order"] == ["3", "2"] and (tmp_path / "ros_node.png").exists()
    assert [(one["first"], one["then"]) for one in told["dependencies"]] == [("3", "2")]


@pytest.mark.slow
def test_a_tracked_spoon_goes_into_the_bowl_and_out_again(tmp_path):
    lines = _output(tmp_path, "10_track.py")
    assert lines[0].startswith("60 frames, ")
    assert "table touch bowl: frames 1-60" in lines
    assert any(line.startswith("bowl partial contain spoon: frames ") for line in lines)


@pytest.mark.slow
def test_in_a_foreign_world_the_counterweight_is_found_and_a_stack_taken_apart(tmp_path):
    lines = _output(tmp_path, "09_own_world.py")
    assert "never moves: table" in lines
    taken = [line.split(":")[0] for line in lines if line[0].isdigit()]
    assert taken[-1] == "3. block"
    assert "plank before weight: counterweight" in lines
    assert any("weight and plank hold each other" in line for line in lines)
    assert [line.split(":")[0] for line in lines[-3:]] == ["remove high", "free low", "free low"]
    assert lines[-1] == "free low: reached"


def test_two_cards_come_apart_with_a_second_hand(tmp_path):
    lines = _output(tmp_path, "06_hold.py")
    assert "with more hands, hold " in lines[0]
    first, held = lines[1].removeprefix("take ").partition(";")[0].split(", ")
    assert f"hold {held} while {first} is taken" in lines[1]
    turns = [float(line.split()[-2]) for line in lines[-2:]]
    assert turns[0] > 1.0 and turns[1] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("frame", [None, FRAMES / "osd_test46.npz"], ids=["simulated", "real"])
def test_a_frame_becomes_a_world_to_act_in(frame, tmp_path):
    if frame is not None and not frame.exists():
        pytest.skip(f"no real frames in {FRAMES}")
    lines = _output(tmp_path, "05_real_frame.py", *([] if frame is None else [str(frame), "1"]))
    assert any(line.startswith("note: the arm's base stands at") for line in lines)
    assert (tmp_path / "real_frame.html").stat().st_size > 100_000


def test_the_driver_of_ros_says_where_there_is_none(tmp_path):
    *_, line = _output(tmp_path, "12_ros_driver.py")
    assert line.startswith(("no ROS 2 here", "the arm is at")) and (tmp_path / "ros_driver.png").exists()


@pytest.mark.slow
def test_position_actuators_of_mujoco_free_the_plate(tmp_path):
    pytest.importorskip("mujoco")
    assert _output(tmp_path, "13_mujoco_driver.py") == ["seed 0: Plate freed in 5 moves. Nothing else moved."]
