"""Placements are held against a fall: what a plan puts down stays, and what may fall is said."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from moving import at
from on_table import BASE

from topple.planner.errors import NoSafePlan
from topple.planner.grasp import grasp_candidates
from topple.planner.placement.placement import Placement
from topple.planner.placement.proof import Proof
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.robots.shapes.fruit import orange
from topple.robots.shapes.tableware import bowl
from topple.robots.world.bodies import Body
from topple.topology.bodies.completed import with_level_undersides
from topple.topology.bodies.solids import Solids
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

UP = np.array([0.0, 0.0, 1.0])
SLAB = np.array([[x, y, z] for x in (-0.4, 0.4) for y in (-0.4, 0.4) for z in (0.0, -0.05)])


def peg() -> Body:
    """A hexagonal peg of 4 cm on a tip that is not below its middle: it stands on none of its ends.

    The best hand at it meets the table where it turns it far enough to lie.
    """
    angles = np.arange(6) * np.pi / 3
    ring = 0.02 * np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([ring, np.full(6, height)]) for height in (0.03, 0.12)]
    return Body.of("peg", [np.vstack([[[0.016, 0.004, 0.0]], *rings])])


def with_peg() -> Scene:
    axis = np.arange(-0.45, 0.45, 0.008)
    x, y = np.meshgrid(axis, axis)
    points = peg().surface(4000, np.random.default_rng(0))
    table = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return Scene({"table": table, "peg": points - [0, 0, points[:, 2].min()]}, fixed=["table"], up=UP)


@pytest.fixture(scope="module")
def dropped() -> Plan:
    best = grasp_candidates("peg", with_peg(), robot("panda"))[:1]
    return plan(with_peg(), ["peg"], "panda", pose_base_to_world=BASE, grasps=best, allow_drop=True)


def raised(x: float, z: float) -> np.ndarray:
    return at(x, 0.0, z)


def on_table(body: Body) -> list[np.ndarray]:
    low = min(float(part[:, 2].min()) for part in body.parts)
    return [part - [0.0, 0.0, low] for part in body.parts]


def known(bodies: Solids, whole: Solids | None = None) -> Situation:
    clouds = {name: np.vstack(list(parts)) for name, parts in bodies.items()}
    return Situation(
        Scene(clouds, fixed=["table"], up=UP), known_solids=bodies, known_completed=whole or bodies
    )


def test_what_stands_holds_and_what_tips_or_is_meant_to_fall_does_not():
    cube, pole = box("cube", (0.05, 0.05, 0.05)), peg()
    place = Placement(raised(0.1, 0.004), 1.0, drop=0.004)
    for body, stays in ((cube, True), (pole, False)):
        bodies = {body.name: on_table(body), "table": [SLAB]}
        proof = Proof(body.name, known(bodies))
        assert proof.holds(place) is stays
        assert not proof.holds(replace(place, falls=True))
        assert (proof.settle(place).turn > 1.0) is not stays


def test_on_a_table_the_whole_body_has_to_stand_and_not_what_was_seen_of_it():
    seen, whole = on_table(peg()), on_table(box("box", (0.04, 0.04, 0.16)))
    bodies = {"thing": seen, "table": [SLAB]}
    place = Placement(raised(0.1, 0.004), 1.0, drop=0.004)
    proof = Proof("thing", known(bodies, {**bodies, "thing": whole}))
    assert proof.holds(place)
    assert not proof.holds(replace(place, into="table", rest="on table"))


def test_what_stays_nowhere_is_no_plan_and_the_reason_says_so():
    best = grasp_candidates("peg", with_peg(), robot("panda"))[:1]
    with pytest.raises(NoSafePlan, match="would not stay as it is let go there, and no drop is allowed"):
        plan(with_peg(), ["peg"], "panda", pose_base_to_world=BASE, grasps=best)


@pytest.mark.slow
def test_an_allowed_drop_is_said_by_its_step_and_told_by_the_check(dropped):
    (step,) = dropped.steps
    assert step.placement.falls and "let go to fall" in step.reason
    checked = plan_from_json(plan_to_json(dropped)).verify(with_peg())
    assert checked.ok
    assert len(checked.allowed) == 1 and "step 1 (peg) is let go to fall" in checked.allowed[0]
    assert checked.to_json()["allowed"] == list(checked.allowed)


def test_the_same_drop_is_refuted_where_its_step_does_not_say_so(dropped):
    (step,) = dropped.steps
    silent = msgspec.structs.replace(step.placement, falls=False)
    claimed = msgspec.structs.replace(dropped, steps=[msgspec.structs.replace(step, placement=silent)])
    checked = claimed.verify(with_peg())
    assert not checked.ok and checked.allowed == ()
    assert checked["turn after letting go"] > 0.5


def test_the_ragged_foot_of_a_carton_is_levelled_and_it_stands():
    carton = on_table(box("carton", (0.08, 0.05, 0.2)))
    corners = np.vstack(carton)
    tip = corners[:, 2] < 0.01
    corners[tip, 2] = (
        0.006 * (1.0 - np.sign(corners[tip, 0])) / 2.0
    )  # one edge 6 mm higher: noise of its foot
    rocker = np.vstack([corners, [[0.012, y, -0.002] for y in (-0.02, 0.02)]])
    place = Placement(raised(0.1, 0.006), 1.0, drop=0.004)
    for parts, stays in (
        ([rocker], False),
        (with_level_undersides({"carton": [rocker]}, ["carton"], UP)["carton"], True),
    ):
        bodies = {"carton": list(parts), "table": [SLAB]}
        proof = Proof("carton", known(bodies))
        assert proof.holds(place) is stays


def test_round_and_leaning_bodies_and_what_never_moves_get_no_foot():
    slope = np.array([[np.cos(0.3), 0.0, np.sin(0.3)], [0.0, 1.0, 0.0], [-np.sin(0.3), 0.0, np.cos(0.3)]])
    bodies = {
        "orange": on_table(orange("orange")),
        "bowl": on_table(bowl()),
        "leaning": [part @ slope.T for part in on_table(box("leaning", (0.08, 0.05, 0.2)))],
        "table": [SLAB],
    }
    found = with_level_undersides(bodies, ["orange", "bowl", "leaning"], UP)
    assert all(found[name] is bodies[name] for name in bodies)
