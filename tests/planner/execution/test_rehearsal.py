"""A world rebuilt from a scene lies as the scene does, in the frame that it says."""

import numpy as np
import pytest
from on_table import BASE, on_table
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from topple.planner.execution.look import Observer
from topple.planner.execution.rehearsal import Rehearsal, Z
from topple.robots.catalog import robot
from topple.robots.shapes import box
from topple.topology.scene.frame import in_frame
from topple.topology.scene.scene import Scene


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0, np.pi])
def test_things_stand_to_the_given_base_as_in_the_scene(angle):
    scene = on_table(
        (box("a", (0.05, 0.05, 0.05)), (0.1, 0.0, 0.0)),
        (box("b", (0.05, 0.05, 0.09)), (-0.05, 0.2, 0.0)),
        x=0.1,
    )
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(angle * Z).as_matrix()
    turned = in_frame(scene, pose, Z)
    with Rehearsal.of(turned, robot("panda"), pose @ BASE) as stage:
        to_base = np.linalg.inv(stage.pose_base_to_world)
        for name in ("a", "b"):
            corners = np.vstack(stage.world.parts(name))
            middle = to_base @ np.append((corners.min(axis=0) + corners.max(axis=0)) / 2.0, 1.0)
            wanted = np.linalg.inv(BASE) @ np.append(scene.clouds[name].mean(axis=0), 1.0)
            assert middle[:2] == pytest.approx(wanted[:2], abs=0.01)
            there = stage.pose_scene_to_world @ np.append(turned.clouds[name].mean(axis=0), 1.0)
            assert np.linalg.norm((corners.mean(axis=0) - there[:3])[:2]) < 0.02


def test_matter_is_rebuilt_and_the_cameras_see_no_object_in_it():
    scene = on_table((box("a", (0.05, 0.05, 0.05)), (0.1, 0.0, 0.0)), x=0.1)
    wall = np.stack(np.meshgrid(-0.15, np.arange(-0.3, 0.3, 0.01), np.arange(0.02, 0.4, 0.01)), axis=-1)
    behind = Scene(
        scene.clouds, scene.fixed, scene.up, scene.viewpoints, matter=wall.reshape(-1, 3), assumptions=()
    )
    with Rehearsal.of(behind, robot("panda"), BASE) as stage:
        eyes = Observer(stage.world, stage.cameras, np.random.default_rng(0), ("table",), robots=())
        seen = eyes.look().scene
    assert set(seen.names) == {"table", "a"}
    there = wall.reshape(-1, 3) @ stage.pose_scene_to_world[:3, :3].T + stage.pose_scene_to_world[:3, 3]
    assert len(seen.matter) > 500
    assert KDTree(there).query(seen.matter)[0].max() < 0.03
