"""guided-tamp-benchmark's shelf tasks: a task of its layout is planned, and its files call nothing."""

import pickle

import pytest
import trimesh

from topple.benchmarks.tamp import rows
from topple.robots.scenarios.scenario import pose_at
from topple.topology.base.errors import InvalidInput


def test_a_task_is_planned_an_arm_in_the_table_is_left_out_and_no_file_calls(tmp_path):
    tasks, meshes = tmp_path / "tasks" / "data", tmp_path / "models" / "data" / "ycbv" / "meshes"
    for folder in (tasks, meshes):
        folder.mkdir(parents=True)
    trimesh.creation.box((50, 50, 100)).export(meshes / "obj_000002.obj")
    made = {"furniture_ids": ["table"], "furniture_params": [{"desk_size": [1.0, 1.0, 0.7]}]}
    made |= {"furniture_poses": [pose_at(0, 0, 0)], "object_ids": ["YCBV_02"]}
    made |= {"q_start": [pose_at(0.1, 0.1, 0.05)], "q_goal": [pose_at(0.1, -0.1, 0.05)]}
    (tasks / "shelf_0.pkl").write_bytes(pickle.dumps(made))
    bases = {0: pose_at(0, 0, 0), 1: pose_at(-0.4, 0, 0), 2: pose_at(-0.4, 0, -0.2)}
    (tasks / "shelf_0_panda_poses.pkl").write_bytes(pickle.dumps(bases))
    share, near, _ = rows(True, 0, lambda text: None, tmp_path)
    assert (share["held"], share["tried"], near["value"]) == (1, 1, 1), share
    (tasks / "shelf_0.pkl").write_bytes(pickle.dumps(print))
    with pytest.raises(InvalidInput, match=r"names builtins\.print"):
        rows(True, 0, lambda text: None, tmp_path)
