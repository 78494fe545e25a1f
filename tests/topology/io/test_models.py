"""Known models are found by name, registered with what one camera saw, and refused where they do not fit."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from topple.planner.cli.main import main
from topple.robots import Camera, World, shapes
from topple.robots.scenarios.scenario import pose_at
from topple.topology import ModelFit, load_scene, with_models
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.io.model_files import meant_by, model_files
from topple.topology.relations.relate import relate
from topple.topology.scene.frame import in_frame
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

SHARED = Path(__file__).resolve().parents[3].parent / "shared" / "data"


@pytest.mark.parametrize(
    ("name", "models", "meant"),
    [
        ("banana", ["011_banana", "025_mug"], ["011_banana"]),
        ("banana_2", ["011_banana", "025_mug"], ["011_banana"]),
        ("011_banana", ["011_banana"], ["011_banana"]),
        ("Banana", ["banana"], ["banana"]),
        ("book_4", ["book_1", "book_4"], ["book_4"]),
        ("obj_000005_2", ["obj_000005", "obj_000006"], ["obj_000005"]),
        ("marbles", ["063-a_marbles", "063-b_marbles"], ["063-a_marbles", "063-b_marbles"]),
        ("can", ["002_can", "003_can"], ["002_can", "003_can"]),
        ("cup", ["011_banana"], []),
    ],
)
def test_a_name_means_the_model_called_so_but_for_numbers(name, models, meant):
    assert meant_by(name, models) == meant


def test_models_are_files_or_folders_with_a_mesh(tmp_path):
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    for place in "a.stl b/mesh.obj b/collision.obj c/google_16k/textured.ply d/d.obj d/e.obj".split():
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        box.export(tmp_path / place)
    (tmp_path / "notes.txt").write_text("0 0 0\n")
    found = {name: file.relative_to(tmp_path).as_posix() for name, file in model_files(tmp_path).items()}
    assert found == {
        "a": "a.stl", "b": "b/mesh.obj", "c": "c/google_16k/textured.ply", "d": "d/d.obj"
    }  # fmt: skip


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> tuple[Scene, Path, dict[str, np.ndarray]]:
    """What one camera saw, the folder of the models, and the true corners of the bodies in the world."""
    folder = tmp_path_factory.mktemp("models")
    with World() as world:
        world.add_table()
        world.add(shapes.mug(), pose_at(-0.1, 0.05, 0))
        world.add(shapes.can(), pose_at(0.1, 0.0, 0))
        lying = pose_at(0.0, -0.12, 0.035)
        lying[:3, :3] = Rotation.from_euler("xz", [90, 20], degrees=True).as_matrix()
        world.add(shapes.bottle(), lying)
        world.settle()
        camera = Camera.looking_at((0.55, -0.3, 0.5), (0, 0, 0.03), width=320, height=240)
        image = camera.look(world, np.random.default_rng(0))
        corners = {}
        for name in world.movable:
            mesh, pose = world.body(name).mesh, world.pose(name)
            corners[name] = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
            place = folder / ("025_mug/mesh.obj" if name == "mug" else f"{name}.ply")
            place.parent.mkdir(exist_ok=True)
            trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(place)
    scene = Scene.from_images([image], fixed=["table"], up=(0, 0, 1))
    assert set(corners) == set(scene.movable)
    return scene, folder, corners


@pytest.fixture(scope="module")
def known(seen: tuple[Scene, Path, dict[str, np.ndarray]]) -> Scene:
    return with_models(seen[0], seen[1])


def test_models_take_the_place_of_what_one_camera_saw(seen, known):
    scene, _, corners = seen
    assert known.whole == set(scene.movable) == {"mug", "can", "bottle"}
    for name, true in corners.items():
        fit = known.models[name]
        assert fit.residual < 0.002 and fit.inliers > 0.9 and 0.15 < fit.visible < 0.8
        assert known.clouds[name].min(axis=0) == pytest.approx(true.min(axis=0), abs=4e-3)
        assert known.clouds[name].max(axis=0) == pytest.approx(true.max(axis=0), abs=4e-3)
        assert known.meshes[name].faces.size
        assert np.array_equal(known.seen(name), scene.clouds[name])
        assert any(note.startswith(f"{name!r} is the model ") for note in known.assumptions)
    assert np.array_equal(known.clouds["table"], scene.clouds["table"])
    assert known.models["mug"].model == "025_mug"


def test_nothing_of_a_known_model_is_guessed(known):
    situation = Situation(known)
    rotation = situation.statics.upright.rotation
    for name in known.movable:
        low, high = known.clouds[name].min(axis=0), known.clouds[name].max(axis=0)
        for points in (situation.surfaces[name] @ rotation, np.concatenate(list(situation.completed[name]))):
            assert (points > low - 2e-3).all() and (points < high + 2e-3).all()
    assert {frozenset((name, "table")) for name in known.movable} == relate(known).meeting


@pytest.mark.slow
def test_another_shape_keeps_what_was_seen_and_one_line_says_so(seen, tmp_path):
    scene = seen[0]
    (tmp_path / "mug.ply").write_bytes((seen[1] / "bottle.ply").read_bytes())
    found = with_models(scene, tmp_path)
    assert found.whole == frozenset() and found.models["mug"].refused is not None
    assert all(np.array_equal(found.clouds[name], scene.clouds[name]) for name in scene.names)
    added = [note for note in found.assumptions if note not in scene.assumptions]
    assert len(added) == 2
    assert added[0].startswith("'mug' stays as it was seen, the model mug does not fit: residual ")
    assert "is called as " in added[1] and "can" in added[1] and "bottle" in added[1]
    assert relate(found).to_json() == relate(scene).to_json()


def test_fits_travel_with_the_scene(known):
    assert pickle.loads(pickle.dumps(known)) == known
    fit = known.models["mug"]
    assert isinstance(fit, ModelFit) and json.loads(json.dumps(fit.to_json()))["registered"] is True
    shift = pose_at(0.1, 0.2, 0.3)
    there = in_frame(known, shift, np.array([0.0, 0.0, 1.0]))
    assert there.whole == known.whole
    assert there.models["mug"].pose_model_to_world == pytest.approx(shift @ fit.pose_model_to_world)
    assert "mug" not in known.with_cloud("mug", fit.seen).models
    assert "mug" not in known.without("mug").models
    with pytest.raises(UnknownObject):
        Scene({"a": fit.seen}, models={"b": fit})


def test_what_is_no_folder_of_models_is_refused(seen, tmp_path):
    with pytest.raises(InvalidInput, match="is no folder: expected one with NAME"):
        with_models(seen[0], tmp_path / "none")
    with pytest.raises(InvalidInput, match="has no models: expected NAME"):
        with_models(seen[0], tmp_path)
    trimesh.creation.box((4, 4, 4)).export(tmp_path / "mug.stl")
    with pytest.raises(InvalidInput, match=r"model 'mug' \(mug.stl\) is 4 m long, .*millimetres"):
        with_models(seen[0], tmp_path)


def test_the_commands_take_a_folder_of_models_or_none(seen, tmp_path, capsys, typed):
    scene, folder, _ = seen
    clouds = {name: cloud for name, cloud in scene.clouds.items() if name in ("can", "table")}
    place = str(tmp_path / "scene.npz")
    np.savez(place, **clouds, fixed=np.array(["table"]), up=scene.up, viewpoints=scene.viewpoints)
    document = typed("relate", place, "--models", folder, "--json").document
    (fit,) = document["models"]
    assert fit["object"] == fit["model"] == "can" and fit["registered"] and fit["residual"] < 0.003
    out = typed("order", "--models", folder, place).out
    assert "Assumed: 'can' is the model can, registered: residual" in out
    assert "models" not in typed("relate", place, "--json").document
    assert main(["relate", "--models", place]) == 2  # the switch of BOP, before a scene
    assert "which has no option models" in capsys.readouterr().err
    assert load_scene(place, models=folder).models["can"].refused is None


@pytest.mark.slow
def test_things_of_the_ycb_set_in_a_real_frame_are_registered(tmp_path):
    frame, models = SHARED / "rgbd" / "ycbvideo_0000.npz", SHARED / "ycb"
    if not frame.exists() or not models.exists():
        pytest.skip("the real frames and the YCB models are not there")
    with np.load(frame) as arrays:
        given = {key: arrays[key] for key in arrays.files}
    names = {8: "009_gelatin_box", 14: "025_mug", 21: "061_foam_brick"}
    np.savez(tmp_path / "frame.npz", **given, ids=np.array(list(names)), names=np.array(list(names.values())))
    scene = load_scene(tmp_path / "frame.npz", models=models)
    assert scene.whole == {"009_gelatin_box", "025_mug"}
    assert any("061_foam_brick" in note and "is called as" in note for note in scene.assumptions)
