"""The tools: each a function of a root and of what it is asked, whose keyword arguments are its inputs."""

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any, get_type_hints

import msgspec

from topple.planner.errors import NoSafePlan, refusal_json
from topple.planner.mcp.proposal import judge_proposal
from topple.planner.mcp.root import Root, SceneSource
from topple.planner.planning.plan_format import Plan, plan_to_json
from topple.planner.tolerances import ALL_PAIRS_UP_TO
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable, write_whole
from topple.topology.situation.situation import Situation

Names = tuple[str, ...]
Tool = Callable[..., dict[str, Any]]


def relate(root: Root, *, scene: SceneSource) -> dict[str, Any]:
    """Relation and gap of every two objects: touch, within, partial within, contain, cross or disjoint."""
    from topple.topology.relations.relate import relate

    found = root.scene(scene)
    told = relate(found).to_json(far=len(found.names) <= ALL_PAIRS_UP_TO)
    return {**told, "assumptions": list(found.assumptions)}


def order(root: Root, *, scene: SceneSource, targets: Names = ()) -> dict[str, Any]:
    """In which order to take things so that the targets, or all, come free; why, and what supports what."""
    from topple.planner.planning.order import order

    return order(root.scene(scene), targets).to_json()


def why(root: Root, *, scene: SceneSource, take: str, gone: Names = ()) -> dict[str, Any]:
    """Propose to take an object next, once others are gone: accepted or refused, with the certificate."""
    return judge_proposal(Situation.of(root.scene(scene)), take, gone)


def check(root: Root, *, scene: SceneSource) -> dict[str, Any]:
    """Whether everything stands: a verdict for each object, what carries it with which force, and margins."""
    from topple.planner.stability.check import check

    return check(root.scene(scene)).to_json()


def plan(
    root: Root, *, scene: SceneSource, goal: str, robot: str = "panda", budget: float = 120, output: str = ""
) -> dict[str, Any]:
    """Plan grasps, places and motions for a goal as "free plate", within a budget [s]; `output` is a file.

    Clients give up after some minutes, so two are taken unless more are asked for.
    """
    from topple.planner.planning.plan import plan
    from topple.robots.catalog import ROBOTS

    _ = ROBOTS[robot]  # no path: a URDF names files anywhere
    place = check_writable(root.place(output)) if output else None
    try:
        found = plan(root.scene(scene), goal, robot, budget=budget, seed=root.seed)
    except NoSafePlan as error:
        return refusal_json("plan", error, goal)
    if place is not None:
        write_whole(place, plan_to_json(found) + b"\n")
    return {**_in_brief(found), "written": output or None}


def verify(root: Root, *, scene: SceneSource, plan: str | dict[str, Any]) -> dict[str, Any]:
    """Check a plan, the path of one or the document, by other means than it was made with."""
    from topple.robots.catalog import ROBOTS

    found = Plan.from_json(root.read(plan) if isinstance(plan, str) else plan)
    if found.robot not in ROBOTS:
        raise InvalidInput(f"the plan is for {found.robot!r}: expected one of {', '.join(ROBOTS)}")
    return found.verify(root.scene(scene), found.robot).to_json()


def next_view(root: Root, *, scene: SceneSource, targets: Names = ()) -> dict[str, Any]:
    """From where a camera would see most of the hidden places that decide the order; null if none would."""
    from topple.planner.planning.next_view import next_view

    found = next_view(root.scene(scene), targets)
    return {"next_view": None if found is None else found.to_json()}


_ALL: tuple[Tool, ...] = (relate, order, why, check, plan, verify, next_view)
TOOLS = {each.__name__: each for each in _ALL}


@cache
def inputs_of(name: str) -> Any:
    """Make a struct of a tool's keyword arguments."""
    hints = get_type_hints(TOOLS[name])
    parameters = [*inspect.signature(TOOLS[name]).parameters.values()][1:]  # after the root
    none = inspect.Parameter.empty
    fields = [(p.name, hints[p.name], *([] if p.default is none else [p.default])) for p in parameters]
    return msgspec.defstruct(name, fields, frozen=True, forbid_unknown_fields=True, kw_only=True)


def schema_of(name: str) -> dict[str, Any]:
    """The JSON schema of what a tool takes, an object at its root."""
    (_,), parts = msgspec.json.schema_components([inputs_of(name)], ref_template="#/$defs/{name}")
    return {**parts.pop(name), "$defs": parts}


def answer(root: Root, name: str, arguments: dict[str, Any]) -> dict[str, Any]:
    """Call a tool.

    Args:
        root: The folder that is served.
        name: The tool.
        arguments: As JSON has them.

    Returns:
        Its answer, fit for JSON.

    Raises:
        InvalidInput: There is no such tool, an argument is none of its, or what it names cannot be used.
        ToppleError: There is no answer: the budget ran out, or the arm finds no place.
    """
    if name not in TOOLS:
        raise InvalidInput(f"there is no tool {name!r}: expected one of {', '.join(TOOLS)}")
    try:
        given = msgspec.convert(arguments, inputs_of(name))
    except msgspec.ValidationError as error:
        raise InvalidInput(f"{name}: {error}") from error
    return TOOLS[name](root, **{key: getattr(given, key) for key in given.__struct_fields__})


def _in_brief(found: Plan) -> dict[str, Any]:
    """A plan without its motions: what is done, why, and how far from all else."""
    steps = [
        {"action": step.action, "object": step.object, "reason": step.reason, "grasp": step.grasp.kind,
         "after": [found.steps[index].object for index in step.after],
         "clearance": round(min(s.clearance for s in step.segments if s.motion is not None), 4)}
        for step in found.steps
    ]  # fmt: skip
    return {
        "format": "topple.plan_in_brief", "format_version": 1, "safe": True, "goal": found.goal,
        "robot": found.robot, "certified": found.certified, "seconds": round(found.seconds, 2),
        "steps": steps, "dependencies": msgspec.to_builtins(found.dependencies),
        "assumptions": list(found.assumptions),
    }  # fmt: skip
