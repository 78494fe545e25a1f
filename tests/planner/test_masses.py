"""What is given of masses and friction decides orders, and PyBullet agrees."""

from collections.abc import Iterator

import numpy as np
import pybullet
import pytest

from topple.planner import order
from topple.planner.simulate.lifts import Stage
from topple.planner.simulate.rebuild import rebuild
from topple.robots import scene_from_world
from topple.topology.scene.scene import Scene
from topple.topology.statics.rest import Statics

Size = tuple[float, float, float]
KEPT = 0.01  # [m] what counts as a move


class Pile:
    """Boxes in a PyBullet world, by name."""

    def __init__(self) -> None:
        self.client: int = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, 0, -9.81, physicsClientId=self.client)
        self.ids: dict[str, int] = {}

    def add(
        self, name: str, size: Size, place: Size, mass: float, friction: float = 0.7, pitch: float = 0.0
    ) -> None:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[length / 2 for length in size], physicsClientId=self.client
        )
        turn = pybullet.getQuaternionFromEuler((0, pitch, 0))
        self.ids[name] = pybullet.createMultiBody(
            mass, shape, basePosition=place, baseOrientation=turn, physicsClientId=self.client
        )
        pybullet.changeDynamics(self.ids[name], -1, lateralFriction=friction, physicsClientId=self.client)

    def rest(self) -> None:
        for _ in range(480):
            pybullet.stepSimulation(physicsClientId=self.client)

    def places(self) -> dict[str, np.ndarray]:
        return {
            name: np.array(pybullet.getBasePositionAndOrientation(number, physicsClientId=self.client)[0])
            for name, number in self.ids.items()
        }

    def seen(self) -> Scene:
        return scene_from_world(self.client, names={number: name for name, number in self.ids.items()})

    def take(self, *names: str) -> dict[str, float]:
        """Take boxes out at once: how far each of the others gets [m]."""
        before = self.places()
        for name in names:
            pybullet.removeBody(self.ids.pop(name), physicsClientId=self.client)
        self.rest()
        return {name: float(np.linalg.norm(now - before[name])) for name, now in self.places().items()}


@pytest.fixture
def pile() -> Iterator[Pile]:
    made = Pile()
    yield made
    pybullet.disconnect(made.client)


def overhanging(pile: Pile) -> Scene:
    """A plank whose middle is beyond the edge of a block, held down by a cube of 1.5 kg."""
    pile.add("table", (1.0, 0.8, 0.02), (0, 0, -0.01), 0.0)
    pile.add("block", (0.12, 0.12, 0.10), (0, 0, 0.05), 1.0)
    pile.add("plank", (0.30, 0.08, 0.01), (0.10, 0, 0.105), 0.3)
    pile.add("cube", (0.04, 0.04, 0.04), (-0.02, 0, 0.13), 1.5)
    pile.rest()
    return pile.seen()


def test_a_plank_depends_on_the_heavy_cube_that_holds_it_down(pile):
    scene = overhanging(pile)
    assert scene.masses == {"block": 1.0, "plank": 0.3, "cube": 1.5}
    found = order(scene)
    held = found.graph.between("plank", "cube")
    assert held is not None and held.reason == "counterweight"
    assert {"plank", "cube"} in [set(group) for group in found.groups], "they hold each other"
    assert pile.take("cube")["plank"] > 2 * KEPT


def test_what_is_taken_in_groups_moves_nothing_else(pile):
    found = order(overhanging(pile))
    left = list(found.order)
    assert sorted(left) == ["block", "cube", "plank"]
    while left:
        now = next((group for group in found.groups if left[0] in group), (left[0],))
        left = [name for name in left if name not in now]
        assert max(pile.take(*now).values()) < KEPT


@pytest.mark.parametrize("masses", [{}, {"cube": 0.02, "plank": 0.3}])
def test_a_light_cube_holds_no_plank(pile, masses):
    scene = overhanging(pile)
    light = Scene(scene.clouds, scene.fixed, scene.up, masses=masses)
    assert order(light).graph.between("plank", "cube") is None


def test_a_load_goes_before_the_cube_that_balances_it(pile):
    pile.add("table", (1.0, 0.8, 0.02), (0, 0, -0.01), 0.0)
    pile.add("block", (0.12, 0.12, 0.10), (0, 0, 0.05), 1.0)
    pile.add("plank", (0.36, 0.10, 0.01), (0.05, 0, 0.105), 0.3)
    pile.add("cube", (0.04, 0.04, 0.04), (-0.04, 0, 0.13), 1.5)
    pile.add("load", (0.06, 0.08, 0.08), (0.19, 0, 0.15), 0.25)
    pile.rest()
    scene = pile.seen()
    found = order(scene)
    assert found.order == ("load", "cube", "plank", "block")
    unweighed = Scene(scene.clouds, scene.fixed, scene.up, friction=scene.friction)
    assert order(unweighed).graph.between("load", "cube") is None
    for name in found.order[:-1]:
        assert max(pile.take(name).values()) < KEPT
    pile.take("block")


def leaning(pile: Pile, friction: float) -> Scene:
    """A plank that leans against a wall at 45 degrees, its foot against a heavy stopper.

    Alone it stays where (1 - f^2) / 2f < tan 45, from f = 0.41 on.
    """
    plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=pile.client)
    pile.ids["table"] = pybullet.createMultiBody(0.0, plane, physicsClientId=pile.client)
    pybullet.changeDynamics(pile.ids["table"], -1, lateralFriction=1.0, physicsClientId=pile.client)
    pile.add("wall", (0.02, 0.30, 0.40), (0.2222, 0, 0.20), 0.0, 1.0)
    pile.add("plank", (0.30, 0.10, 0.02), (0.0990, 0, 0.1131), 0.4, friction, -np.pi / 4)
    pile.add("stopper", (0.06, 0.12, 0.05), (-0.0442, 0, 0.025), 3.0, 1.0)
    pile.rest()
    return pile.seen()


@pytest.mark.parametrize(("friction", "stays"), [(0.8, True), (0.3, False)])
def test_a_leaning_plank_needs_its_stopper_where_it_is_slippery(pile, friction, stays):
    scene = leaning(pile, friction)
    assert scene.friction == {"table": 1.0, "wall": 1.0, "plank": friction, "stopper": 1.0}
    assert (order(scene).graph.between("plank", "stopper") is None) is stays
    assert (pile.take("stopper")["plank"] < KEPT) is stays


def test_a_rebuilt_world_has_the_masses_and_the_friction_that_were_given(pile):
    scene = overhanging(pile).weighed(friction={"table": 0.9, "cube": 0.33})
    stage = Stage(rebuild(Statics.of(scene)), 0.4, 0.4)
    world = stage.world
    told = {
        name: pybullet.getDynamicsInfo(number, -1, physicsClientId=world.client)[:2]
        for name, number in world.ids.items()
    }
    moved = stage.without("cube")
    stage.close()
    assert told["cube"] == pytest.approx((1.5, 0.33))
    assert told["plank"] == pytest.approx((0.3, 0.7))
    assert told["the floor"][1] == pytest.approx(0.9)
    assert stage.sagged["plank"].distance < KEPT, "it stands, as the cube holds it"
    assert moved["plank"].distance > KEPT


def test_what_is_given_is_no_longer_assumed(pile):
    scene = overhanging(pile)
    bare = Scene(scene.clouds, scene.fixed, scene.up)
    said = order(bare).assumptions
    assert any("masses were not given: 700 kg/m³" in line for line in said)
    assert any("friction was not given" in line for line in said)
    partly = order(bare.weighed({"cube": 1.5}, {"table": 0.6})).assumptions
    assert any(line.startswith("the mass of block, plank was not given") for line in partly)
    assert any(line.startswith("the friction of block, plank, cube was not given") for line in partly)
    assert not any("not given" in line for line in order(scene).assumptions)


def test_grams_for_kilograms_are_pointed_out(pile):
    said = order(overhanging(pile).weighed({"plank": 300.0})).assumptions
    assert [
        line for line in said if "denser than any matter" in line and line.startswith("plank was given 300")
    ]
