"""Plans written as PDDL are parsed and solved by a planner of another project."""

from solving import solved

from topple.planner.export.pddl import domain_and_problem
from topple.planner.formats.plan_structs import GraspData, PlacementData, Step
from topple.planner.planning.plan_format import Plan

EYE = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]


def handled(name: str, action: str, after: list[int]) -> Step:
    grasp, place = GraspData("pinch", EYE, 0.05, 1.0), PlacementData(EYE)
    return Step(object=name, action=action, reason="", after=after, grasp=grasp, placement=place, segments=[])


def planned(*steps: Step) -> tuple[str, str]:
    plan = Plan(
        goal="free plate", robot="panda", joints=["a"], seed=0, pose_base_to_world=EYE, base_searched=False,
        q_start=[0.0], order=[step.object for step in steps], dependencies=[], steps=list(steps),
    )  # fmt: skip
    return domain_and_problem(plan)


def test_another_planner_takes_things_in_the_safe_order():
    steps = [
        handled("fork", "remove", []),
        handled("Can 1", "remove", []),
        handled("spoon", "remove", [0]),
        handled("plate", "free", [0, 1, 2]),
    ]
    actions = solved(*planned(*steps))
    taken = [action for action in actions if action.startswith("take")]
    assert taken[-1] == "take-o-plate"
    assert set(taken) == {"take-o-fork", "take-o-can-1", "take-o-spoon", "take-o-plate"}
    assert taken.index("take-o-fork") < taken.index("take-o-spoon")
    assert actions[-1] == "put-o-plate"


def test_what_needs_nothing_first_is_taken_alone():
    assert solved(*planned(handled("plate", "free", []))) == ["take-o-plate", "put-o-plate"]
