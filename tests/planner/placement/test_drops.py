import numpy as np
import pytest
from moving import at
from scipy.spatial.transform import Rotation

from topple.planner.placement.drops import pick_staying, try_standing
from topple.planner.placement.placement import Placement
from topple.planner.simulate import sandbox
from topple.planner.simulate.sandbox import Sandbox
from topple.robots import engines
from topple.robots.engines import INSTALLED, rehearsal_world
from topple.robots.shapes.boxes import box
from topple.robots.shapes.fruit import lemon, strawberry
from topple.robots.shapes.tableware import bowl
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

UP = np.array([0.0, 0.0, 1.0])
AXIS = np.arange(-0.4, 0.4, 0.01)
GROUND = np.stack(np.meshgrid(AXIS, AXIS, [0.0]), -1).reshape(-1, 3)
SLAB = np.array([[x, y, z] for x in (-0.4, 0.4) for y in (-0.4, 0.4) for z in (0.0, -0.05)])


def cloud(body: Body, x: float = 0.0) -> np.ndarray:
    points = body.surface(3000, np.random.default_rng(0))
    return points + np.array([x, 0.0, -points[:, 2].min()])


def standing_parts(body: Body, x: float = 0.0) -> list[np.ndarray]:
    low = min(float(part[:, 2].min()) for part in body.parts)
    return [part + np.array([x, 0.0, -low]) for part in body.parts]


def shifted(x: float, z: float) -> np.ndarray:
    return at(x, 0.0, z)


def test_a_dropped_box_stands_on_what_is_below_and_the_fall_can_be_repeated():
    cube = box("cube", (0.05, 0.05, 0.05))
    bodies = {"cube": standing_parts(cube), "base": standing_parts(box("base", (0.1, 0.1, 0.04)), 0.3)}
    drops = Sandbox().fill("cube", bodies, UP)
    first = drops.release(shifted(0.3, 0.05))
    second = drops.release(shifted(0.3, 0.05))
    assert np.allclose(first[:3, 3], [0.3, 0.0, 0.04], atol=0.003)
    assert np.allclose(first, second, atol=1e-4)


def test_what_is_let_go_over_a_rim_does_not_stay_and_in_the_middle_it_does():
    dish, fruit = bowl(), lemon()
    table = np.stack(np.meshgrid(np.arange(-0.4, 0.8, 0.01), np.arange(-0.4, 0.4, 0.01)), -1).reshape(-1, 2)
    ground = np.column_stack([table, np.zeros(len(table))])
    scene = Scene({"bowl": cloud(dish, 0.3), "lemon": cloud(fruit), "table": ground}, fixed=["table"], up=UP)
    slab = np.vstack([[[x, y, z] for x in (-0.4, 0.8) for y in (-0.4, 0.4)] for z in (0.0, -0.05)])
    bodies = {"bowl": standing_parts(dish, 0.3), "lemon": standing_parts(fruit), "table": [slab]}
    rim = float(np.ptp(scene.clouds["bowl"][:, 0])) / 2.0
    middle, edge = Placement(shifted(0.3, 0.03), 1.0), Placement(shifted(0.3 + rim + 0.01, 0.06), 0.9)
    assert pick_staying([edge, middle], "lemon", "bowl", Situation(scene, known_solids=bodies)) == (
        [middle],
        [middle],
    )

    full = {**bodies, "berry": [part + np.array([0.3, 0.0, 0.02]) for part in standing_parts(strawberry())]}
    assert pick_staying([middle], "lemon", "bowl", Situation(scene, known_solids=full), ["berry"]) == (
        [],
        [middle],
    )


def test_what_would_tip_over_is_put_down_as_it_comes_to_lie():
    stick = box("stick", (0.02, 0.02, 0.2))
    scene = Scene({"stick": cloud(stick), "table": GROUND}, fixed=["table"], up=UP)
    upright, tilted = shifted(0.1, 0.004), shifted(0.1, 0.03)
    tilted[:3, :3] = [[np.cos(0.3), 0.0, np.sin(0.3)], [0.0, 1.0, 0.0], [-np.sin(0.3), 0.0, np.cos(0.3)]]
    places = [Placement(upright, 1.0, drop=0.004), Placement(tilted, 0.9, drop=0.004)]
    bodies = {"stick": standing_parts(stick), "table": [SLAB]}
    stays, lies = try_standing(places, "stick", Situation(scene, known_completed=bodies))
    assert stays is places[0]
    assert lies.rolls
    assert abs(float(lies.pose_before_to_after[:3, :3][2, 2])) < 0.1


def test_what_tips_from_how_it_is_now_may_be_let_go_so_where_no_hand_gets_down_with_it_lying():
    pole = box("pole", (0.004, 0.02, 0.2))
    scene = Scene({"pole": cloud(pole), "table": GROUND}, fixed=["table"], up=UP)
    leaning = shifted(0.1, 0.005)
    leaning[:3, :3] = [[np.cos(0.1), 0.0, np.sin(0.1)], [0.0, 1.0, 0.0], [-np.sin(0.1), 0.0, np.cos(0.1)]]
    place = Placement(leaning, 0.9, drop=0.004)
    lies, falls = try_standing(
        [place], "pole", Situation(scene, known_completed={"pole": standing_parts(pole), "table": [SLAB]})
    )
    assert lies.rolls and lies.tilt(UP) > 1.4
    assert falls.rolls and np.allclose(falls.pose_before_to_after, leaning)


@pytest.mark.parametrize("engine", INSTALLED)
def test_drops_are_rehearsed_on_whatever_engine_is_installed(engine, monkeypatch):
    worlds: list[PhysicalWorld] = []

    def watched() -> PhysicalWorld:
        worlds.append(rehearsal_world())
        return worlds[-1]

    monkeypatch.setattr(engines, "DEFAULT_ENGINE", engine)
    monkeypatch.setattr(sandbox, "rehearsal_world", watched)
    cube, ball = box("cube", (0.05, 0.05, 0.05)), lemon()
    slab = {"table": [SLAB]}
    drops = Sandbox().fill("cube", {**slab, "cube": standing_parts(cube)}, UP)
    flat, tilted = drops.release(shifted(0.0, 0.01)), shifted(0.0, 0.03)
    tilted[:3, :3] = Rotation.from_euler("y", 20.0, degrees=True).as_matrix()
    tipped = drops.release(tilted)
    assert np.allclose(flat, np.eye(4), atol=2e-3)
    assert abs(tipped[2, 2]) > 0.999

    bodies = {**slab, "lemon": standing_parts(ball), "cube": standing_parts(cube, 0.1)}
    drops.fill("lemon", bodies, UP, ["cube"])
    drops.release(shifted(-0.2, 0.003))
    beside = drops.push()
    drops.release(shifted(0.065, 0.0))
    into = drops.push()
    assert beside < 0.2 < 0.5 < into
    assert [world.engine for world in worlds] == [engine]  # kept from one question to the next
    assert set(worlds[0].names) == {"table", "cube", "lemon"} and worlds[0].fixed == {"table"}
