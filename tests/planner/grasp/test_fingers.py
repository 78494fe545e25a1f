"""Hands that come in where no camera saw come last, and are said to."""

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from on_table import BASE, on_table

from topple.benchmarks.sabotages.caught import ROUGH
from topple.planner.decide.arrange import Order
from topple.planner.errors import NoSafePlan
from topple.planner.failure import FailureLog
from topple.planner.fallbacks import RELAXATIONS
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.rank import rank_grasps
from topple.planner.grasp.shape import coming_unseen, shapes_of
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import plan_from_json, plan_to_json
from topple.planner.transfer.handling import Handling
from topple.planner.verify import verify
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes.boxes import box
from topple.robots.world.camera import Camera, Noise
from topple.robots.world.world import World
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

PANDA = robot("panda")
HOME = Station(PANDA, BASE, np.asarray(PANDA.home))
LOW, OTHER = (-0.8, 0.0, 0.5), (0.8, 0.5, 0.6)
"""Cameras: one from before the block, one from behind it."""


def shaded(*eyes: tuple[float, float, float], wall: bool = True, lit: bool = False) -> Scene:
    """A block, a wall whose shadow, as seen from `LOW`, is on its left, and a block in the light."""
    things = {"block": (box("block", (0.05, 0.05, 0.06)), (0.0, 0.0, 0.0))}
    things |= {"wall": (box("wall", (0.02, 0.06, 0.15)), (-0.12, 0.065, 0.0))} if wall else {}
    things |= {"lit": (box("lit", (0.05, 0.05, 0.06)), (0.0, -0.25, 0.0))} if lit else {}
    if not eyes:
        return on_table(*things.values())
    with World() as world:
        world.add_table(size=(1.6, 1.6))
        for body, place in things.values():
            world.add(body, pose_at(*place))
        rng = np.random.default_rng(0)
        images = [
            Camera.looking_at(eye, (0.0, -0.05, 0.0), noise=Noise.none()).look(world, rng) for eye in eyes
        ]
    return Scene.from_images(images, fixed=["table"], up=(0, 0, 1))


def pinch(height: float = 0.05, score: float = 1.0) -> Grasp:
    """A hand from above whose fingers are left and right of the block."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = height
    return Grasp("block", "pinch", pose, 0.05, 0.066, score)


@pytest.mark.parametrize(
    ("scene", "unseen"),
    [(shaded(LOW), True), (shaded(LOW, wall=False), False), (shaded(LOW, OTHER), False), (shaded(), False)],
    ids=["in a shadow", "no shadow", "another camera", "no camera"],
)
def test_a_finger_in_a_shadow_comes_unseen(scene, unseen):
    assert coming_unseen([pinch()], Situation(scene), shapes_of(PANDA)).tolist() == [unseen]
    (ranked,) = rank_grasps(scene, [pinch()], "panda")
    assert (ranked.why, ranked.grasp.unseen) == (None, unseen)


def test_where_something_was_taken_away_is_free_and_its_shadow_is_not():
    situation, away = Situation(shaded(LOW)), np.eye(4)
    away[:3, 3] = [0.0, -0.4, 0.0]
    places = np.array([[-0.12, 0.065, 0.05], [0.0, 0.065, 0.05], [0.0, -0.1, 0.05]])
    assert situation.shown(places, 0.005).tolist() == [False, False, True]
    for after in (situation.moved(["wall"], away), situation.without("wall")):
        assert after.shown(places, 0.005).tolist() == [True, False, True]


def test_hands_that_come_seen_are_before_all_others():
    found = grasp_candidates("block", shaded(LOW), PANDA)
    unseen = [grasp.unseen for grasp in found]
    assert {True, False} <= set(unseen)
    assert unseen == sorted(unseen)
    assert max(g.score for g in found if g.unseen) > min(g.score for g in found if not g.unseen)


def test_a_step_whose_hand_comes_unseen_says_so_and_others_do_not():
    hidden, open_ = (
        plan(shaded(LOW, wall=wall), ["block"], "panda", pose_base_to_world=BASE, grasps=[pinch()])
        for wall in (True, False)
    )
    (step,) = hidden.steps
    assert step.unseen and "unseen" in step.fallbacks
    assert any("no camera saw the hand's way to block" in words for words in hidden.assumptions)
    document = plan_to_json(hidden)
    assert json.loads(document)["steps"][0]["unseen"] is True
    assert plan_from_json(document) == hidden
    assert [step.unseen for step in open_.steps] == [False]
    assert not any("no camera saw" in words for words in open_.assumptions)
    with pytest.raises(NoSafePlan, match="not tried, as the relaxations leave it out: unseen"):
        plan(shaded(LOW).with_base(BASE), ["block"], "panda", grasps=[pinch()], relaxations=RELAXATIONS[:-1])


def test_of_grasps_given_one_that_comes_seen_is_used_before_a_better_one():
    scene = shaded(LOW, wall=False)
    turned = pinch().pose_tool_to_world @ np.array(
        [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )
    behind = Grasp("block", "pinch", turned, 0.05, 0.066, 1.0)
    (step,) = plan(scene.with_base(BASE), ["block"], "panda", grasps=[behind, pinch(score=0.1)]).steps
    assert not step.unseen
    assert step.grasp.score == pytest.approx(0.1)
    (step,) = plan(scene, ["block"], "panda", pose_base_to_world=BASE, grasps=[behind]).steps
    assert step.unseen


def test_what_may_go_as_well_goes_before_what_is_taken_unseen():
    def by_name(situation: Situation, targets: Sequence[str], **_: object) -> Order:
        found = order(situation, targets)
        return replace(found, order=tuple(sorted(found.order)))

    orders = [
        plan(
            shaded(*eyes, lit=True), ["block", "lit"], "panda", pose_base_to_world=BASE, orderer=by_name,
            grasps=[pinch()], verify=False,
        ).order
        for eyes in ((), (LOW,))
    ]  # fmt: skip
    assert orders == [["block", "lit"], ["lit", "block"]]


def test_a_mark_taken_off_a_step_together_with_its_fallback_is_refuted():
    hidden, open_ = shaded(LOW), shaded(LOW, OTHER)
    made = plan(hidden, ["block"], "panda", pose_base_to_world=BASE, grasps=[pinch()])
    forged = json.loads(plan_to_json(made))
    forged["steps"][0] |= {"unseen": False, "fallbacks": []}
    checked = verify(plan_from_json(json.dumps(forged)), hidden, step=ROUGH)
    assert [residual.name for residual in checked.failed] == ["hands that come in unseen and are not said to"]
    assert checked.failed[0].witness == "step 1 (block)"
    assert [proof.what for proof in checked.refuted] == ["it tells of itself what is so"]
    said = verify(made, hidden, step=ROUGH)
    assert said.ok
    assert not said.allowed
    assert any("cameras saw all of its way" in words for words in verify(made, open_, step=ROUGH).allowed)


def test_hands_are_marked_as_they_are_made_whatever_their_grasp_says():
    handling = Handling("block", Situation(shaded(LOW)), HOME)
    lit = Handling("block", Situation(shaded(LOW, OTHER)), HOME)
    for asked, unseen in ((handling, {True}), (lit, {False})):
        grasps = [replace(pinch(), unseen=not min(unseen))]
        found = list(asked.hands(grasps, np.asarray(PANDA.home), FailureLog(frozenset())))
        assert {hand.unseen for hand, _ in found} == unseen
