"""Centres of mass: refused where they cannot be true, kept wherever the scene goes, and weighed."""

import copy
import json
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.topology import InvalidInput, Scene, Situation, UnknownObject, load_scene
from topple.topology.scene.frame import enlarge, in_frame
from topple.topology.statics.rest import Statics

AXIS = np.linspace(-0.5, 0.5, 60)
TABLE = np.stack(np.meshgrid(AXIS, AXIS, [0.0]), -1).reshape(-1, 3)
INNER = (0.1, 0.0, 0.205)


def box(size: tuple[float, float, float], at: tuple[float, float, float]) -> np.ndarray:
    grid = np.stack(np.meshgrid(*(np.linspace(-0.5, 0.5, 21),) * 3), -1).reshape(-1, 3)
    return grid[np.abs(grid).max(axis=1) == 0.5] * size + np.array(at)


def overhanging(**centres: tuple[float, float, float]) -> Scene:
    """A plank whose middle is 4 cm beyond the edge of a block."""
    clouds = {
        "table": TABLE,
        "block": box((0.12, 0.12, 0.2), (0, 0, 0.1)),
        "plank": box((0.3, 0.08, 0.01), INNER),
    }
    return Scene(clouds, ["table"], (0, 0, 1), centres=centres)


HELD = (0.02, 0.0, 0.205)


def test_forces_hold_what_has_its_weight_over_its_support_and_nothing_else():
    assert Statics.of(overhanging()).unexplained["plank"] > 0.3
    assert Statics.of(overhanging(plank=HELD)).unexplained["plank"] < 1e-6
    assert Statics.of(overhanging(plank=(0.08, 0.0, 0.205))).unexplained["plank"] > 0.3


def test_what_falls_without_a_weight_on_it_depends_on_where_the_centre_is():
    def fallen(**centres: tuple[float, float, float]) -> set[str]:
        scene = overhanging(**centres).with_cloud("weight", box((0.05, 0.05, 0.05), (-0.03, 0, 0.235)))
        statics = Statics.of(scene.weighed({"weight": 2.0, "plank": 0.2}))
        both = set(statics.fallen_without(["weight"])), set(statics.unsteady_without(["weight"]))
        assert both[0] == both[1]
        return both[0]

    assert fallen() == {"plank"}
    assert fallen(plank=HELD) == set()


def test_a_scene_keeps_them_and_moves_them_along():
    scene = overhanging(plank=HELD, block=(0.0, 0.01, 0.06))
    for same in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene), scene.with_up((0, 0, 2))):
        assert np.allclose(same.centres["plank"], HELD)
    assert set(scene.without("plank").centres) == {"block"}
    assert set(scene.with_cloud("plank", scene.clouds["plank"] + 1.0).centres) == {"block"}
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_euler("z", 0.5).as_matrix(), (0.3, -0.1, 0.2)
    there = pose[:3, :3] @ HELD + pose[:3, 3]
    situation = Situation.of(scene).moved(["plank"], pose)
    assert np.allclose(situation.scene.centres["plank"], there)
    assert np.allclose(situation.scene.centres["block"], (0.0, 0.01, 0.06))
    assert np.allclose(in_frame(scene, pose, np.array([0, 0, 1.0])).centres["plank"], there)
    assert np.allclose(enlarge(scene, 3.0).centres["plank"], 3.0 * np.array(HELD))
    completed = Situation.of(scene).with_completed("plank")
    assert np.allclose(completed.scene.centres["plank"], HELD)
    with pytest.raises(ValueError, match="read-only"):
        scene.centres["plank"][0] = 1.0


def test_they_are_read_from_files_and_written(tmp_path):
    overhanging(plank=HELD).save(tmp_path / "scene.npz")
    assert np.allclose(load_scene(tmp_path / "scene.npz").centres["plank"], HELD)
    folder = tmp_path / "scene"
    folder.mkdir()
    for name, cloud in overhanging().clouds.items():
        np.savetxt(folder / f"{name}.xyz", cloud)
    (folder / "scene.json").write_text(
        json.dumps({"fixed": ["table"], "up": [0, 0, 1], "centres": {"plank": HELD}})
    )
    assert np.allclose(load_scene(folder).centres["plank"], HELD)


@pytest.mark.parametrize(
    ("centres", "says"),
    [
        ({"plank": (0.1, 0.2)}, "centre of mass of 'plank' is .*: expected three finite numbers"),
        ({"plank": (0.1, np.nan, 0.1)}, "expected three finite numbers"),
        ({"plank": "here"}, "centre of mass of 'plank' holds text"),
        ({"plank": (0.1, 0.0, 5.0)}, "outside of its points, .* not in the object's own"),
    ],
)
def test_what_is_no_centre_is_refused_in_one_line(centres, says):
    with pytest.raises(InvalidInput, match=says):
        Scene(overhanging().clouds, centres=centres)  # type: ignore[arg-type]
    with pytest.raises(UnknownObject, match="object with a centre of mass 'cup'"):
        overhanging().weighed(centres={"cup": (0, 0, 0)})
