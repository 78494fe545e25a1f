import json
import math

import numpy as np
import pytest
from on_table import BASE, on_table

from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.verify import Verification, verify
from topple.planner.verify.claims import OF_PLANS, OF_STEPS
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

ROUGH = 0.02  # [rad]: what is broken here is broken everywhere


def stacked() -> Scene:
    """A block on a block, and a tall box beside them."""
    return on_table(
        (box("lower", (0.06, 0.06, 0.06)), (0.0, 0.0, 0.0)),
        (box("upper", (0.05, 0.05, 0.05)), (0.0, 0.0, 0.0605)),
        (box("tall", (0.08, 0.08, 0.25)), (0.05, 0.2, 0.0)),
        points=2000,
    )


@pytest.fixture(scope="module")
def found() -> Plan:
    return plan(stacked(), ["lower"], robot("panda"), pose_base_to_world=BASE)


@pytest.fixture(scope="module")
def checked(found: Plan) -> Verification:
    return plan_from_json(plan_to_json(found)).verify(stacked())


def test_a_plan_read_back_holds_by_every_other_means(checked):
    bad = [(r.name, r.value, r.witness) for r in checked.residuals if not r.ok]
    assert not bad
    assert checked.ok
    assert checked.states > 1000


def test_without_the_scene_what_needs_it_is_infinite_and_the_rest_holds(found):
    bare = verify(found, step=ROUGH)
    assert {residual.name for residual in bare.left_out} == {
        "dependencies of the scene broken",
        "hands that come in unseen and are not said to",
        "seen points entered",
        "points outside of the plan's bodies",
        "up of the plan against the scene's",
        "bodies of the plan beyond the scene's",
        "hidden sides of the plan beyond the scene's",
        "base of the plan against the scene's",
        "pressed into what it is put on or into",
        "assumptions of the scene or the arm left out",
        "dependencies that the scene does not give",
        "actions that the goal does not ask for",
        "objects fixed in the plan or the scene alone",
        "goal clauses unmet",
    }
    assert math.isinf(bare["goal clauses unmet"])
    assert not bare.failed
    assert not bare.ok


def test_the_record_is_json_with_units_and_nulls(found, checked):
    document = json.loads(json.dumps(checked.to_json()))
    assert document["ok"] is True
    assert {row["unit"] for row in document["residuals"]} <= {"m", "rad", "rad/s", "s", "kg", "N", "1"}
    bare = verify(found, step=ROUGH).to_json()
    assert None in [row["value"] for row in bare["residuals"]]


def test_each_step_says_what_is_proven_by_which_means_and_nothing_is_open(checked):
    assert [(one.step, one.object, one.action) for one in checked.steps] == [
        (0, "upper", "remove"),
        (1, "lower", "free"),
    ]
    for one in checked.steps:
        assert {proof.means for proof in one.proven} >= {
            "hand state replayed",
            "force and friction of what holds it",
            "rated payload, gravity torques on the way",
            "cubics through the samples",
            "swept certificate derived again",
            "dependencies derived again",
            "let go in PyBullet",
        }
        assert not one.refuted and not one.unchecked
    assert all(proof.shown for proof in checked.whole)
    assert checked.to_json()["steps"][1]["proofs"][0]["shown"] is True
    assert "torques of speeding up" in checked.unasked


def test_every_residual_is_one_row_of_the_table(checked):
    rows = [(check.name, check.unit) for claim in (*OF_STEPS, *OF_PLANS) for check in claim.checks]
    assert rows == [(residual.name, residual.unit) for residual in checked.residuals]
    assert len({name for name, _ in rows}) == len(rows) > 40


def test_without_the_scene_steps_say_what_was_not_looked_at(found):
    bare = verify(found, step=ROUGH)
    for one in bare.steps:
        assert {(proof.what, proof.detail) for proof in one.unchecked} == {
            ("so it is by what was seen", "no scene was given"),
            ("no seen point is entered", "no scene was given"),
        }
    assert all(proof.shown is None for proof in bare.whole)


def test_what_is_known_to_be_too_heavy_is_shown_not_to_be_held(found):
    checked = verify(found, stacked().weighed({"lower": 30.0, "upper": 0.1}), step=ROUGH)
    (first,), (second,) = (
        [proof for proof in one.proofs if proof.what == "its weight is held"] for one in checked.steps
    )
    assert first.shown is True and first.detail.endswith("weighed")
    assert second.shown is False and "294 N, the fingers hold" in second.detail


def test_what_states_far_apart_do_not_see_no_certificate_covers(found):
    """Looked at in their first and last state alone, motions past the tall box are not proven free.

    A plan that says they were is refuted, and one that does not is none.
    """
    checked = verify(spoiled(found, bend_and_promise_no_room), stacked(), step=100.0)
    assert checked["collisions (python-fcl)"] <= 0.0
    (between,) = [proof for proof in checked.steps[0].refuted if proof.means.startswith("swept")]
    assert "transfer: said to be proven free" in between.detail
    assert any(proof.means.startswith("swept") for proof in checked.steps[1].proven)


def test_what_has_no_motion_is_not_taken_for_proven(found):
    checked = verify(spoiled(found, do_nothing_in_step_1), stacked(), step=ROUGH)
    assert {proof.detail for proof in checked.steps[0].unchecked} >= {
        "there is no motion",
        "it is never let go",
        "nothing is held, or it has no volume",
    }
    assert [proof.means for proof in checked.steps[0].refuted] == ["hand state replayed"]


@pytest.mark.parametrize(
    ("change", "step", "what"),
    [
        ("bend_into_the_tall_box", 0, "arm and load meet nothing"),
        ("swap_the_steps", 0, "so it is by what was seen"),
        ("hasten", 0, "the arm can follow"),
        ("put_it_into_the_air", 1, "it is let go where the step says"),
        ("let_it_fall_unsaid", 1, "it stays there"),
        ("take_hold_beside", 1, "it is held from grasp to release"),
    ],
)
def test_the_step_in_which_it_is_spoiled_is_the_one_refuted(found, change, step, what):
    checked = checked_once(found, globals()[change])
    assert what in [proof.what for proof in checked.steps[step].refuted]
    assert what in [proof.what for proof in checked.steps[1 - step].proven]
    assert all(proof.detail for proof in checked.refuted)


def do_nothing_in_step_1(document: dict) -> None:
    document["steps"][0]["segments"] = []


def spoiled(found: Plan, change: object) -> Plan:
    """The plan with a change to its document."""
    document = json.loads(plan_to_json(found))
    change(document)  # type: ignore[operator]
    return plan_from_json(json.dumps(document))


def bend_into_the_tall_box(document: dict) -> None:
    """The transfer of step 1 goes through a state in which the hand stands in the tall box."""
    arm = robot("panda")
    down = np.array([[1.0, 0, 0, 0.55], [0, -1, 0, 0.2], [0, 0, -1, 0.15], [0, 0, 0, 1]])
    q = arm.inverse(down)[0][0]
    motion = next(s for s in document["steps"][0]["segments"] if s["kind"] == "transfer")["motion"]
    motion["positions"][len(motion["positions"]) // 2] = q.tolist()


def bend_and_promise_no_room(document: dict) -> None:
    bend_into_the_tall_box(document)
    next(s for s in document["steps"][0]["segments"] if s["kind"] == "transfer")["clearance"] = 0.0


def swap_the_steps(document: dict) -> None:
    document["steps"].reverse()
    document["steps"][0]["after"], document["steps"][1]["after"] = [], [0]


def swap_the_steps_and_say_so(document: dict) -> None:
    """What is likely is not excused by going against it with open eyes."""
    gone = document["dependencies"][0]
    swap_the_steps(document)
    document["dependencies"], document["steps"][0]["against"] = [], [gone]


def take_it_for_less_than_was_seen(document: dict) -> None:
    thing = next(thing for thing in document["objects"] if thing["name"] == "upper")
    thing["whole"] = [[[x, y, 0.08 + (z - 0.08) / 2] for x, y, z in part] for part in thing["parts"]]


def hasten(document: dict) -> None:
    motion = document["steps"][0]["segments"][0]["motion"]
    motion["times"] = [time / 6 for time in motion["times"]]
    motion["velocities"] = [[6 * value for value in row] for row in motion["velocities"]]


def put_it_into_the_air(document: dict) -> None:
    document["steps"][1]["placement"]["pose_before_to_after"][2][3] += 0.1


def let_it_fall_unsaid(document: dict) -> None:
    document["steps"][1]["placement"]["drop"] -= 0.1


def take_hold_beside(document: dict) -> None:
    document["steps"][1]["grasp"]["pose_tool_to_world"][1][3] += 0.1


def hold_it_otherwise(document: dict) -> None:
    document["steps"][1]["attachments"][0]["pose_start_to_tool"][1][3] += 0.05


def excuse_everything(document: dict) -> None:
    document["steps"][0]["segments"][0]["may_touch"] = [["panda_hand", "tall"]]


def leave_the_goal_out(document: dict) -> None:
    document["steps"].pop()
    document["dependencies"] = []


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (bend_into_the_tall_box, "collisions (python-fcl)"),
        (bend_into_the_tall_box, "positions from velocities"),
        (bend_into_the_tall_box, "motions without a proof"),
        (swap_the_steps, "dependencies of the plan broken"),
        (swap_the_steps, "dependencies of the scene broken"),
        (swap_the_steps, "continuity"),
        (swap_the_steps_and_say_so, "dependencies of the scene broken"),
        (take_it_for_less_than_was_seen, "bodies outside of their wholes"),
        (hasten, "joint velocities"),
        (hasten, "joint accelerations"),
        (put_it_into_the_air, "tool at the place"),
        (put_it_into_the_air, "object against its place"),
        (let_it_fall_unsaid, "shift after letting go"),
        (take_hold_beside, "tool at the grasp"),
        (hold_it_otherwise, "attachment against grasp"),
        (excuse_everything, "pairs that may touch without a reason"),
        (leave_the_goal_out, "goal clauses unmet"),
    ],
)
def test_what_is_spoiled_is_found_where_it_is(found, change, name):
    residuals = {r.name: r for r in checked_once(found, change).residuals}
    assert residuals[name].value > 0.0
    assert residuals[name].witness


_CHECKED: dict[object, Verification] = {}


def checked_once(found: Plan, change: object) -> Verification:
    """One check for each change: several tests look at its residuals."""
    if change not in _CHECKED:
        _CHECKED[change] = verify(spoiled(found, change), stacked(), step=ROUGH)
    return _CHECKED[change]


def test_another_scene_or_arm_is_refused(found):
    with pytest.raises(InvalidInput, match="tall"):
        found.verify(stacked().without("tall"))
    with pytest.raises(InvalidInput, match="give its arm"):
        found.verify(stacked(), "iiwa")
