"""Things go where a caller says: every step ends there, and a plan in which one does not is refuted."""

import json
from typing import Any

import numpy as np
import pytest
from on_table import BASE

from topple.benchmarks.sabotages.caught import CASES, ROUGH, scene_for
from topple.planner.placement.away import BODIES, Away, Destination
from topple.planner.planning.plan import plan
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify import verify
from topple.topology.base.errors import InvalidInput

SCENE = scene_for(CASES[0][0])  # a block on a block
WAYS: dict[Away, str | tuple[str | float, ...]] = {
    Away.LIFT: "lift",
    Away.BIN: "bin",
    Away.ZONE: ("zone", 0.0, 0.25, 0.5, 0.55),
    Away.HAND_OVER: ("hand-over", 0.35, -0.35, 0.45),
}
HANDED_ON = "it ends where things go that are taken"


@pytest.fixture(scope="module")
def made() -> dict[Away, Plan]:
    """The lower block freed, away in each way."""
    there = SCENE.with_base(BASE)
    return {how: plan(there, ["lower"], "panda", away=words) for how, words in WAYS.items()}


def changed(made: Plan, change: Any) -> Plan:
    document = json.loads(plan_to_json(made))
    change(document)
    return plan_from_json(json.dumps(document))


@pytest.mark.parametrize("how", list(WAYS))
def test_both_blocks_go_there_and_every_check_holds(how, made):
    found = made[how]
    assert [step.object for step in found.steps] == ["upper", "lower"]
    assert [step.placement.how for step in found.steps] == [how, how]
    checked = verify(found, SCENE, step=ROUGH)
    assert checked.ok, checked.failed
    assert all(any(proof.what == HANDED_ON for proof in step.proofs) for step in checked.steps)
    assert plan_from_json(plan_to_json(found)) == found
    assert found.away is not None and found.away.how == how and found.certified


def test_what_is_lifted_or_held_out_stays_in_the_hand(made):
    for how in (Away.LIFT, Away.HAND_OVER):
        for step in made[how].steps:
            assert [part.kind for part in step.segments][-1] == SegmentKind.TRANSFER
            assert step.segments[-1].holding == step.object


def test_a_lift_that_ends_lower_is_too_near(made):
    def lower(document: dict[str, Any]) -> None:
        last = document["steps"][0]["segments"][-1]["motion"]
        for key in ("times", "positions", "velocities"):
            last[key] = last[key][:1]

    checked = verify(changed(made[Away.LIFT], lower), SCENE, step=ROUGH)
    assert HANDED_ON in {proof.what for proof in checked.refuted}


def test_a_box_that_stands_elsewhere_catches_nothing(made):
    def aside(document: dict[str, Any]) -> None:
        walls = next(thing for thing in document["objects"] if thing["name"] == BODIES[Away.BIN])
        walls["parts"] = [[[x + 0.6, y, z] for x, y, z in part] for part in walls["parts"]]

    checked = verify(changed(made[Away.BIN], aside), SCENE, step=ROUGH)
    assert "it stays there" in {proof.what for proof in checked.refuted}


def test_places_beside_what_is_vouched_for_are_refuted(made):
    def aside(key: str, by: float) -> Any:
        def change(document: dict[str, Any]) -> None:
            document["away"][key][0][3] += by

        return change

    for how in (Away.ZONE, Away.HAND_OVER):
        checked = verify(changed(made[how], aside("pose_to_world", 0.5)), SCENE, step=ROUGH)
        assert {proof.what for proof in checked.refuted} == {HANDED_ON}


def test_a_step_that_goes_elsewhere_than_the_plan_says_is_no_plan(made):
    def table(document: dict[str, Any]) -> None:
        document["steps"][-1]["placement"]["how"] = ""

    def unknown(document: dict[str, Any]) -> None:
        document["steps"][0]["placement"]["how"] = "bin"

    checked = verify(changed(made[Away.LIFT], table), SCENE, step=ROUGH)
    assert HANDED_ON in {proof.what for proof in checked.refuted}
    with pytest.raises(InvalidInput, match=r"placement\.how` has 'bin', expected one of on, within, lift"):
        changed(made[Away.LIFT], unknown)


def test_what_went_onto_the_area_is_in_the_way_of_the_next(made):
    first, second = (np.array(step.placement.pose_before_to_after) for step in made[Away.ZONE].steps)
    middles = [SCENE.clouds[name].mean(axis=0) for name in ("upper", "lower")]
    there = [
        pose[:3, :3] @ middle + pose[:3, 3] for pose, middle in zip((first, second), middles, strict=True)
    ]
    assert np.linalg.norm((there[0] - there[1])[:2]) > 0.05
    in_base = (np.array(there) - BASE[:3, 3]) @ BASE[:3, :3]
    assert ((in_base[:, :2] > [0.0, 0.25]) & (in_base[:, :2] < [0.5, 0.55])).all()


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ("lft", "away is 'lft': expected one of table, lift, bin, zone, hand-over"),
        (("zone", 0.0, 0.1, 0.2), "away zone has 3 numbers: expected X0 Y0 X1 Y1"),
        (("hand-over", 0.1, 0.2, float("nan")), "expected finite X Y Z"),
        (("hand-over", 0.1, 0.2, "up"), "expected X Y Z in metres"),
        (("zone", 0.1, 0.1, 0.1, 0.4), "has no room"),
    ],
)
def test_what_is_no_place_is_refused(words, match):
    with pytest.raises(InvalidInput, match=match):
        Destination.of(words)


def test_a_box_in_what_is_seen_is_refused():
    with pytest.raises(InvalidInput, match="away bin: it stands in what is seen"):
        plan(SCENE.with_base(BASE), ["lower"], "panda", away=("bin", 0.5, 0.0, 0.0, 0.0, 0.4, 0.3, 0.2))
