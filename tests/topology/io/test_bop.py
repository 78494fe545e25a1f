"""Scenes of BOP datasets, written by the simulated camera."""

import json
import shutil
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from topple.robots import Camera, World, shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Noise
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.hull import Hull
from topple.topology.io import load_scene
from topple.topology.relations.relate import relate
from topple.topology.views.image import DepthImage

EXAMPLE = Path(__file__).parents[3] / "examples" / "02_write_bop.py"
PLATE, CAN, BLOCK = "obj_000001", "obj_000002", "obj_000003"


def _writer():
    spec = spec_from_file_location("write_bop", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.write_bop


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, DepthImage, dict[str, np.ndarray]]:
    """A scene of two images, what the first camera saw, and the true corners of all bodies in the world."""
    with World() as world:
        world.add_table()
        world.add(shapes.plate(), pose_at(0, 0, 0))
        world.add(shapes.can(), pose_at(0, 0, 0.012))
        world.add(shapes.block(), pose_at(0.2, 0.15, 0))
        world.settle()
        cameras = [
            Camera.looking_at(eye, (0, 0, 0.03), width=320, height=240, noise=Noise.none())
            for eye in ((0.5, -0.3, 0.5), (-0.4, 0.5, 0.4))
        ]
        scene = _writer()(tmp_path_factory.mktemp("bop"), world, cameras)
        corners = {name: np.concatenate(world.parts(name)) for name in world.movable}
        return scene, cameras[0].look(world), corners


@pytest.fixture
def scene(written: tuple[Path, DepthImage, dict[str, np.ndarray]], tmp_path: Path) -> Path:
    """A copy of its own of the scene in its dataset."""
    shutil.copytree(written[0].parents[1], tmp_path / "bop")
    return tmp_path / "bop" / "test" / "000001"


def _changed(file: Path, image: str, **values: object) -> None:
    document = json.loads(file.read_text())
    entry = document[image] if isinstance(document[image], dict) else document[image][0]
    entry.update(values)
    file.write_text(json.dumps(document))


def test_what_was_seen_stands_where_the_camera_saw_it(written):
    folder, image, _ = written
    scene = load_scene(folder, image=0)
    assert scene.names == (PLATE, CAN, BLOCK, "table")
    seen = image.clouds()
    for name, true in zip((PLATE, CAN, BLOCK), ("plate", "can", "block"), strict=True):
        away = KDTree(seen[true]).query(scene.clouds[name])[0]
        assert away.max() < 2e-4 and abs(len(away) - len(seen[true])) < 0.01 * len(away)  # steps of the depth
    assert scene.viewpoints == pytest.approx(image.viewpoint[None])
    assert scene.fixed == {"table"}
    assert scene.up == pytest.approx([0, 0, 1], abs=1e-3)


def test_models_stand_at_their_true_poses(written):
    folder, _, corners = written
    scene = load_scene(folder, image=1, models=True)
    for name, true in zip((PLATE, CAN, BLOCK), corners.values(), strict=True):
        box, cloud = Hull.of(true), scene.clouds[name]
        assert cloud.min(axis=0) == pytest.approx(box.lower, abs=2e-3)
        assert cloud.max(axis=0) == pytest.approx(box.upper, abs=2e-3)
        assert scene.meshes[name].faces.size
    assert scene.fixed == {"table"}
    assert relate(scene).between(CAN, "table").relation == "disjoint"
    assert relate(scene).between(CAN, PLATE).relation != "disjoint"


def test_both_ways_tell_the_same_relations(written):
    seen, placed = (
        relate(load_scene(written[0], image=0, models=models)).meeting for models in (False, True)
    )
    assert (
        seen == placed == {frozenset((PLATE, "table")), frozenset((BLOCK, "table")), frozenset((CAN, PLATE))}
    )


def test_a_second_object_of_one_model_has_a_name_of_its_own(scene):
    document = json.loads((scene / "scene_gt.json").read_text())
    document["0"][2]["obj_id"] = 2
    (scene / "scene_gt.json").write_text(json.dumps(document))
    assert load_scene(scene, image=0).names == (PLATE, CAN, "obj_000002_2", "table")


def test_without_masks_the_models_are_taken(scene):
    shutil.rmtree(scene / "mask_visib")
    found = load_scene(scene)
    assert set(found.meshes) == {PLATE, CAN, BLOCK}
    assert any("models at their true poses" in note for note in found.assumptions)
    assert any("image 0 of 2 is taken" in note for note in found.assumptions)


def test_a_pixel_of_two_masks_belongs_to_none(scene):
    before = len(load_scene(scene, image=0).clouds[PLATE])
    can = np.asarray(Image.open(scene / "mask_visib" / "000000_000001.png"))
    plate = np.asarray(Image.open(scene / "mask_visib" / "000000_000000.png"))
    Image.fromarray(np.maximum(can, plate)).save(scene / "mask_visib" / "000000_000001.png")
    found = load_scene(scene, image=0)
    assert PLATE not in found.names and before > 100
    assert any("that several masks claim are left out" in note for note in found.assumptions)


def test_what_is_missing_or_broken_is_named(scene):
    with pytest.raises(InvalidInput, match="has no image 7: expected one of 0, 1"):
        load_scene(scene, image=7)
    (scene.parents[1] / "models" / "obj_000002.ply").unlink()
    with pytest.raises(InvalidInput, match=r"has no models/obj_000002\.ply"):
        load_scene(scene, image=0, models=True)
    (scene / "mask_visib" / "000000_000002.png").unlink()
    with pytest.raises(InvalidInput, match=r"has no mask_visib/000000_000002\.png"):
        load_scene(scene, image=0)
    (scene / "depth" / "000001.png").write_bytes(b"\x89PNG broken")
    with pytest.raises(InvalidInput, match=r"depth/000001\.png is no picture: expected a PNG"):
        load_scene(scene, image=1)
    _changed(scene / "scene_gt.json", "1", obj_id="can")
    with pytest.raises(InvalidInput, match="object 0 has the obj_id 'can'"):
        load_scene(scene, image=1)


@pytest.mark.parametrize(
    ("file", "values", "said"),
    [
        ("scene_camera.json", {"depth_scale": 100.0}, "reaches 3977 m with depth_scale 100"),
        ("scene_camera.json", {"depth_scale": 0}, "depth_scale is 0"),
        ("scene_camera.json", {"cam_K": [1, 2]}, "cam_K has shape"),
        ("scene_camera.json", {"cam_R_w2c": [2, 0, 0, 0, 2, 0, 0, 0, 2]}, "not rigid"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(scene, file, values, said):
    _changed(scene / file, "0", **values)
    with pytest.raises(InvalidInput, match=said):
        load_scene(scene, image=0)


def test_a_gap_in_the_depth_is_told_and_models_are_taken_when_asked_for(scene):
    (scene / "depth" / "000000.png").unlink()
    with pytest.raises(
        InvalidInput, match=r"has no depth/000000\.png, and has depth/000001\.png: .* models=True"
    ):
        load_scene(scene, image=0)
    assert CAN in load_scene(scene, image=0, models=True).names
    assert CAN in load_scene(scene, image=1).names
    shutil.rmtree(scene / "depth")  # a dataset without any is one of models
    assert CAN in load_scene(scene, image=0).names


def test_the_folder_of_a_dataset_is_told_which_scenes_it_has(scene):
    for folder in (scene.parent, scene.parent.parent):
        with pytest.raises(InvalidInput, match=r"is no scene, and holds scenes of BOP: .*test/000001$"):
            load_scene(folder)


def test_a_scale_that_is_missing_or_wrong_is_named_beside_the_depth_it_makes(scene):
    _changed(scene / "scene_camera.json", "0", depth_scale=100.0)
    with pytest.raises(
        InvalidInput, match=r"depth/000000\.png reaches \d+ m with depth_scale 100 in scene_cam"
    ):
        load_scene(scene, image=0)
    document = json.loads((scene / "scene_camera.json").read_text())
    del document["0"]["depth_scale"]
    (scene / "scene_camera.json").write_text(json.dumps(document))
    picture = np.asarray(Image.open(scene / "depth" / "000000.png")).astype(np.int64) * 4
    Image.fromarray(picture.clip(0, 65535).astype(np.uint16)).save(scene / "depth" / "000000.png")
    with pytest.raises(InvalidInput, match=r"with depth_scale 1 in scene_camera\.json, since none is given"):
        load_scene(scene, image=0)


def test_a_split_without_truth_is_told(scene):
    (scene / "scene_gt.json").unlink()
    with pytest.raises(
        InvalidInput, match=r"has no scene_gt\.json: expected the folder of a scene whose truth"
    ):
        load_scene(scene, image=0)


def test_other_formats_have_no_images(tmp_path):
    np.savez(tmp_path / "scene.npz", box=np.random.default_rng(0).uniform(0, 0.1, (50, 3)))
    with pytest.raises(InvalidInput, match="is of the format 'file', which has no option image"):
        load_scene(tmp_path / "scene.npz", image=3)
