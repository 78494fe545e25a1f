"""What stands, tips, slides, floats, falls and is in each other: from meshes of any size, and clouds."""

import io
import json
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

import topple
from topple.benchmarks.check import SPOILS, cases
from topple.benchmarks.truth.designed import designed
from topple.planner.cli.main import main
from topple.planner.report.check_page import ASIDE, CARRIES, FAILS, PUSHED, check_page, check_picture
from topple.planner.report.palette import css
from topple.planner.simulate.play import play
from topple.planner.stability.check import StabilityCheck, check
from topple.robots.collision.convex import hull_of
from topple.robots.engines import playing_on
from topple.robots.world.bodies import join_meshes
from topple.testing import assert_stands
from topple.topology import InvalidInput, Mesh, Scene
from topple.topology.geometry.rigid import move_points
from topple.topology.io.geometry import sampled_mesh

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FACES = hull_of(CUBE)[1]


def box(
    size: tuple[float, float, float], at: tuple[float, float, float], pitch: float = 0.0, yaw: float = 0.0
) -> Mesh:
    turn = Rotation.from_euler("yz", [pitch, yaw])
    return Mesh(turn.apply(hull_of(CUBE)[0] * size) + np.array(at), FACES)


TABLE = box((1.0, 1.0, 0.04), (0, 0, -0.02))
BOOK = box((0.2, 0.15, 0.03), (0, 0, 0.015))


FRICTION_OF_BRICKS = {"left": 0.8, "right": 0.8, "block": 0.8}


def scene(meshes: Mapping[str, Mesh], fixed: tuple[str, ...] = ("table",), **given: object) -> Scene:
    every = {"table": TABLE, **meshes}
    clouds = {name: sampled_mesh(mesh.vertices, mesh.faces) for name, mesh in every.items()}
    return Scene(clouds, fixed, (0, 0, 1), meshes=every, **given)  # type: ignore[arg-type]


def verdicts(found: StabilityCheck) -> dict[str, str]:
    return {name: str(each.verdict) for name, each in found.objects.items()}


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_a_mug_two_millimetres_beyond_the_edge_tips_and_before_it_stands(size):
    """Of objects of 1 cm, of the size of hands, and of 1 m; turned, too."""
    turn = Rotation.from_euler("xyz", [0.4, -0.7, 1.1]).as_matrix()

    def with_mug_at(x: float) -> Scene:
        meshes = {"table": TABLE, "book": BOOK, "mug": box((0.08, 0.08, 0.1), (x, 0, 0.08))}
        large = {name: Mesh(mesh.vertices * size @ turn.T, mesh.faces) for name, mesh in meshes.items()}
        clouds = {name: sampled_mesh(mesh.vertices, mesh.faces) for name, mesh in large.items()}
        return Scene(clouds, ["table"], turn @ [0, 0, 1], meshes=large)

    found = check(with_mug_at(0.1 + 0.002 / size))
    assert found.exact
    assert verdicts(found) == {"book": "stands", "mug": "tips"}
    assert found.sentence() == "1 of 2 stand; mug tips over the edge of book, 2 mm beyond"
    found = check(with_mug_at(0.1 - 0.002 / size))
    assert found.stands
    mug = found.objects["mug"]
    assert mug.margins is not None
    assert mug.margins.centre == pytest.approx(0.002, abs=1e-5)
    assert mug.margins.tilt == pytest.approx(np.arctan(0.002 / (0.05 * size)), rel=0.01)


def test_margins_are_those_of_a_block_by_hand():
    found = check(scene({"block": box((0.08, 0.06, 0.2), (0, 0, 0.1))}, masses={"block": 2.0}))
    (block,) = found.objects.values()
    assert block.margins is not None
    assert block.margins.centre == pytest.approx(0.03, abs=1e-4)
    assert np.degrees(block.margins.tilt) == pytest.approx(np.degrees(np.arctan(0.03 / 0.1)), abs=0.05)
    assert block.margins.push == pytest.approx(2.0 * 9.81 * 0.03 / 0.2, rel=0.01)
    (carry,) = block.carried_by
    assert carry.name == "table"
    assert carry.force == pytest.approx(2.0 * 9.81, rel=1e-6)
    assert not block.by_friction


def test_a_counterweight_holds_and_what_falls_without_it_is_said():
    meshes = {
        "block": box((0.12, 0.12, 0.2), (0, 0, 0.1)),
        "plank": box((0.3, 0.08, 0.01), (0.1, 0, 0.205)),
        "cube": box((0.04, 0.04, 0.04), (-0.02, 0, 0.23)),
    }
    masses = {"block": 1.0, "plank": 0.3, "cube": 1.5}
    found = check(scene(meshes, masses=masses))
    assert found.stands
    assert found.objects["cube"].falls_with == ("plank",)
    assert set(found.objects["block"].falls_with) == {"plank", "cube"}
    light = check(scene(meshes, masses={**masses, "cube": 0.1}))
    assert verdicts(light) == {"block": "stands", "plank": "tips", "cube": "falls"}
    held = check(scene({n: meshes[n] for n in ("block", "plank")}, centres={"plank": (0.03, 0, 0.205)}))
    assert held.stands, "its weight is said to be over the block"


def test_a_chain_is_told_by_what_fails_first():
    stack = {
        "low": box((0.1, 0.1, 0.1), (0, 0, 0.055)),
        "high": box((0.1, 0.1, 0.1), (0.03, 0, 0.155)),
        "beside": box((0.05, 0.05, 0.05), (0.3, 0, 0.025)),
    }
    found = check(scene(stack))
    assert verdicts(found) == {"low": "floats", "high": "falls", "beside": "stands"}
    assert found.objects["low"].amount == pytest.approx(0.005, abs=1e-6)
    assert found.objects["high"].others == ("low",)
    sunk = check(scene({**stack, "low": box((0.1, 0.1, 0.1), (0, 0, 0.047))}))
    assert verdicts(sunk)["low"] == "penetrates"
    assert sunk.objects["low"].others == ("table",)
    assert sunk.objects["low"].amount == pytest.approx(0.003, abs=1e-5)
    assert verdicts(sunk)["high"] == "floats"


def test_a_load_that_tips_its_carrier_falls_with_it():
    meshes = {
        "foot": box((0.04, 0.1, 0.1), (0, 0, 0.05)),
        "board": box((0.2, 0.1, 0.02), (0.019, 0, 0.11)),
        "load": box((0.05, 0.05, 0.05), (0.09, 0, 0.145)),
    }
    found = check(scene(meshes, masses={"foot": 1.0, "board": 0.1, "load": 1.0}))
    assert verdicts(found) == {"foot": "stands", "board": "tips", "load": "falls"}


@pytest.mark.parametrize(("degrees", "verdict"), [(22.0, "stands"), (29.0, "slides"), (75.0, "tips")])
def test_friction_holds_on_a_slope_up_to_its_angle(degrees, verdict):
    angle = np.radians(degrees)
    up = np.array([np.sin(angle), 0, np.cos(angle)])
    place = 0.03 * up + [0, 0, 0.3]
    meshes = {
        "ramp": box((0.4, 0.3, 0.02), (0, 0, 0.3), angle),
        "block": box((0.06, 0.06, 0.04), (place[0], place[1], place[2]), angle),
    }
    found = check(scene(meshes, ("table", "ramp")))
    assert verdicts(found) == {"block": verdict}
    assert found.objects["block"].by_friction == (verdict == "stands")


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.3])
def test_friction_counts_in_full_up_the_slope(yaw):
    slope = np.arctan(0.5)
    for angle, verdict in ((slope - 0.01, "stands"), (slope + 0.01, "slides")):
        turn = Rotation.from_euler("z", yaw) * Rotation.from_euler("y", angle)
        above = np.array([0, 0, 0.3])
        ramp = Mesh(above + turn.apply(CUBE * [0.3, 0.2, 0.02]), FACES)
        block = Mesh(above + turn.apply(np.array([0, 0, 0.025]) + CUBE * [0.06, 0.05, 0.03]), FACES)
        friction = {"ramp": 1.0, "block": 0.5}
        found = check(scene({"ramp": ramp, "block": block}, ("table", "ramp"), friction=friction))
        assert verdicts(found) == {"block": verdict}


def test_what_two_walls_hold_by_friction_is_carried_by_them():
    walls = {"left": box((0.1, 0.2, 0.4), (-0.1, 0, 0.2)), "right": box((0.1, 0.2, 0.4), (0.1, 0, 0.2))}
    held = {**walls, "block": box((0.1, 0.1, 0.05), (0, 0, 0.25))}
    found = check(scene(held, ("table", "left", "right"), masses={"block": 1.0}, friction=FRICTION_OF_BRICKS))
    block = found.objects["block"]
    assert {carry.name for carry in block.carried_by} == {"left", "right"}
    assert block.by_friction
    assert sum(carry.force for carry in block.carried_by) * 0.64 >= 9.8


def test_the_page_of_a_check_says_the_verdict_and_draws_forces(tmp_path):
    meshes = {"book": BOOK, "mug": box((0.08, 0.08, 0.1), (0.104, 0, 0.08))}
    tipping = scene(meshes, masses={"book": 0.5})
    text = check_page(tipping, check(tipping).to_json(), "shelf")
    assert "<h1>1 of 2 stand</h1>" in text
    assert "mug tips over the edge of book, 4 mm beyond" in text
    (view,) = json.loads(text.split('id="data">')[1].split("</script>")[0])["views"]
    assert {arrow["colour"] for arrow in view["arrows"]} == {css(c) for c in (FAILS, CARRIES, ASIDE, PUSHED)}
    carrying = next(arrow for arrow in view["arrows"] if arrow["colour"] == css(CARRIES))
    assert carrying["to"][:2] == pytest.approx([0, 0], abs=0.05), "under the book"
    assert carrying["to"][2] > carrying["from"][2], "upwards"
    picture = Image.open(io.BytesIO(check_picture(tipping, check(tipping).to_json())))
    drawn = {tuple(colour) for colour in np.asarray(picture.convert("RGB")).reshape(-1, 3).tolist()}
    assert {FAILS, CARRIES, PUSHED} <= drawn


def test_pybullet_scenes_at_rest_stand():
    tried = 0
    for seed in range(9000, 9006):
        _, resting = designed(seed)
        meshes = {
            body.name: Mesh(move_points(whole.vertices, resting.poses[body.name]), whole.faces)
            for body in resting.bodies
            if (whole := join_meshes([hull_of(part) for part in body.parts]))
        }
        found = check(scene(meshes, ("table", *resting.fixed)), margins=False)
        assert found.stands, f"{seed}: {found.sentence()}"
        tried += len(found.objects)
    assert tried > 20


def test_every_spoilt_scene_of_blocks_is_told():
    tried = 0
    for case in cases("blocks", 1, 1):
        found = verdicts(check(case.scene, margins=False))
        if "1 mm" not in case.spoil:
            assert found == dict(case.truth), case.spoil
            tried += 1
    assert tried == len(SPOILS) - 2


def test_clouds_stand_within_their_noise_and_float_beyond_it():
    rng = np.random.default_rng(0)
    for height, verdict in ((0.0, "stands"), (0.02, "floats")):
        exact = scene({"book": BOOK, "mug": box((0.08, 0.08, 0.1), (0.02, 0, 0.08 + height))})
        clouds = {name: cloud + rng.normal(0, 5e-4, cloud.shape) for name, cloud in exact.clouds.items()}
        found = check(Scene(clouds, ["table"], (0, 0, 1)), margins=height == 0.0)
        assert not found.exact
        assert verdicts(found) == {"book": "stands", "mug": verdict}


def test_the_command_says_it_in_its_first_line_and_its_exit_code(tmp_path, capsys, typed):
    codes = {}
    for offset in (0.104, 0.08):
        folder = tmp_path / str(offset)
        folder.mkdir()
        for name, mesh in (
            ("table", TABLE),
            ("book", BOOK),
            ("mug", box((0.08, 0.08, 0.1), (offset, 0, 0.08))),
        ):
            lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices.tolist()]
            lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces.tolist()]
            (folder / f"{name}.obj").write_text("\n".join(lines))
        codes[offset] = main(["check", str(folder), "--fixed", "table", "--up", "0", "0", "1", "--json"])
        document = json.loads(capsys.readouterr().out)
        assert document["stands"] == (offset == 0.08)
        assert ("margins" in document["objects"][1]) == document["stands"]
    assert codes == {0.104: 1, 0.08: 0}
    first = typed("check", tmp_path / "0.104", "--up", "0", "0", "1", code=1).out.splitlines()[0]
    assert first.endswith("1 of 2 stand; mug tips over the edge of book, 4 mm beyond")
    assert main(["check", str(tmp_path / "nowhere.npz")]) == 2
    with pytest.raises(AssertionError, match="mug tips over the edge of book, 4 mm beyond"):
        assert_stands(topple.load_scene(tmp_path / "0.104", fixed="table", up=(0, 0, 1)))
    assert_stands(topple.load_scene(tmp_path / "0.08", fixed="table", up=(0, 0, 1)))


def test_clouds_of_which_none_is_a_convex_body_are_checked():
    rng = np.random.default_rng(0)
    clouds = {"table": np.column_stack([rng.uniform(-0.5, 0.5, (4000, 2)), np.zeros(4000)])}
    clouds["foam"] = rng.uniform((-0.05, -0.05, 0.0), (0.05, 0.05, 0.1), (3000, 3))  # points all through it
    assert check(Scene(clouds, ["table"], (0, 0, 1))).sentence() == "1 of 1 stand"


def test_a_mesh_whose_faces_have_no_area_is_taken_as_its_points():
    wire = Mesh(box((0.1, 0.1, 0.1), (0, 0, 0.05)).vertices, np.array([[0, 0, 1], [2, 3, 3]]))
    clouds = {"table": TABLE.vertices, "wire": wire.vertices}
    found = check(Scene(clouds, ["table"], (0, 0, 1), meshes={"table": TABLE, "wire": wire}))
    assert not found.exact


def test_what_cannot_be_checked_is_refused():
    with pytest.raises(InvalidInput, match="nothing in the scene can move"):
        check(scene({}))
    with pytest.raises(InvalidInput, match="does not say where up is"):
        check(Scene({"mug": CUBE}))


def test_a_stack_withstands_by_its_weights_what_the_programme_of_forces_says(monkeypatch):
    """On rough surfaces: a pyramid of friction is inside of the cone; what falls is the same, too."""
    meshes = {
        "low": box((0.1, 0.12, 0.05), (0, 0, 0.025), yaw=0.3),
        "plank": box((0.2, 0.05, 0.02), (0.06, 0.01, 0.06), yaw=0.1),
        "weight": box((0.05, 0.05, 0.08), (0.0, 0.0, 0.11)),
        "other": box((0.04, 0.04, 0.1), (0.12, 0.01, 0.12)),
    }
    stacked = scene(meshes, friction=dict.fromkeys(["table", *meshes], 2.0), masses={"weight": 2.0})
    found = check(stacked)
    monkeypatch.setattr("topple.planner.stability.check.as_stack", lambda _, island: island)
    programmed = check(stacked)
    assert found.stands
    for name, each in found.objects.items():
        other = programmed.objects[name]
        assert each.falls_with == other.falls_with
        assert [(c.name, pytest.approx(c.force)) for c in each.carried_by] == [
            (c.name, c.force) for c in other.carried_by
        ]
        assert each.margins is not None
        assert other.margins is not None
        for figure in ("centre", "tilt", "push"):
            assert getattr(each.margins, figure) == pytest.approx(getattr(other.margins, figure), rel=1e-3)


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_simulation_says_the_same_and_where_it_does_not_that_is_shown(engine, tmp_path, typed):
    """Of what stands, tips and floats; and where statics is made to say something else."""
    pytest.importorskip("pybullet" if engine == "bullet" else engine)
    meshes = {
        "book": BOOK,
        "mug": box((0.08, 0.08, 0.1), (0.105, 0, 0.08)),
        "block": box((0.08, 0.06, 0.1), (-0.2, 0, 0.05)),
        "high": box((0.08, 0.06, 0.1), (-0.2, 0.2, 0.1)),
    }
    with playing_on(engine):
        made = scene(meshes)
        found = check(made)
        played = play(made, found)
        assert played.engine == engine
        assert played.disagreeing == ()
        assert played.moves["block"].distance < 0.002
        assert played.moves["mug"].distance > 0.02
        assert played.moves["high"].distance == pytest.approx(0.05, abs=0.003)
        said = replace(found, objects={**found.objects, "mug": found.objects["block"]})
        assert play(made, said).disagreeing == ("mug",)
        made.save(tmp_path / "made")
        found = typed("check", tmp_path / "made", "--play", "--json", code=1).document
        assert found["played"]["disagreeing"] == []
