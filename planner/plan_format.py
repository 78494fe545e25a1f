"""A plan as data: frozen structs that are written as JSON and read back equal."""

from typing import Any

import msgspec

from topple.planner.segments import KINDS
from topple.topology.errors import InvalidInput

FORMAT = "topple.plan"
FORMAT_VERSION = 1

Matrix = list[list[float]]


class HandState(msgspec.Struct, frozen=True, forbid_unknown_fields=False):
    """How the hand stands: distance of the pads and extension of the cup [m]."""

    opening: float
    cup_extension: float


class Motion(msgspec.Struct, frozen=True):
    """A joint trajectory: times (t,) [s], positions (t, n) [rad], velocities (t, n) [rad/s]."""

    times: list[float]
    positions: Matrix
    velocities: Matrix


class SegmentData(msgspec.Struct, frozen=True):
    """One piece of a step; `motion` is null for grasp and release, `holding` names what is in the hand."""

    kind: str
    tool: str
    hand: HandState
    motion: Motion | None = None
    holding: str | None = None


class GraspData(msgspec.Struct, frozen=True):
    """How an object is held; the pose is that of the tool frame in the world."""

    kind: str
    pose_tool_to_world: Matrix
    width: float
    score: float
    reason: str = ""


class PlacementData(msgspec.Struct, frozen=True):
    """Where it goes: the rigid transform of the object in the world, and how it then lies."""

    pose_before_to_after: Matrix
    rest: str = ""


class Step(msgspec.Struct, frozen=True):
    """One pick and place.

    Attributes:
        object: What is moved.
        action: "remove" what is in the way, "free" a target, or "place" it where the goal says.
        reason: Why, in a sentence.
        after: Indices of the steps that have to be done before this one.
        grasp: How it is held.
        placement: Where it goes.
        segments: What the arm does, in order.
    """

    object: str
    action: str
    reason: str
    after: list[int]
    grasp: GraspData
    placement: PlacementData
    segments: list[SegmentData]


class DependencyData(msgspec.Struct, frozen=True):
    """`first` has to go before `then`."""

    first: str
    then: str
    reason: str
    confidence: float


class ObjectData(msgspec.Struct, frozen=True):
    """What the plan took an object for before anything moved: convex parts, vertices in the world [m]."""

    name: str
    fixed: bool
    parts: list[Matrix]


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """A whole sequence.

    Attributes:
        format: Always "topple.plan".
        format_version: Of this layout.
        goal: In words.
        robot: The arm's name.
        joints: Names of its joints, as in the trajectories' columns.
        seed: All searches started from it.
        pose_base_to_world: Where the arm stands.
        base_searched: Whether that was searched for, because nobody gave it.
        q_start: Joint values the plan starts from [rad].
        order: What is handled, first to last.
        dependencies: Why that order.
        steps: What is done.
        objects: Everything that was kept clear of.
        assumptions: What was assumed and not seen.
        seconds: Duration of the motions [s].
        tried: What was dropped on the way, with counts.
    """

    format: str = FORMAT
    format_version: int = FORMAT_VERSION
    goal: str
    robot: str
    joints: list[str]
    seed: int
    pose_base_to_world: Matrix
    base_searched: bool
    q_start: list[float]
    order: list[str]
    dependencies: list[DependencyData]
    steps: list[Step]
    objects: list[ObjectData] = []
    assumptions: list[str] = []
    seconds: float = 0.0
    tried: dict[str, int] = {}


def plan_to_json(plan: Plan) -> bytes:
    """Write a plan.

    Args:
        plan: The plan.

    Returns:
        UTF-8 JSON.
    """
    return msgspec.json.encode(plan)


def plan_from_json(data: bytes | str, name: str = "plan.json") -> Plan:
    """Read a plan back.

    Args:
        data: JSON as `plan_to_json` writes it; unknown keys are passed over.
        name: Of the file, for messages.

    Returns:
        The plan, equal to the one written.

    Raises:
        InvalidInput: The text is no plan; the message has the path of the bad field.
    """
    try:
        plan = msgspec.json.decode(data, type=Plan)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"{name} is no plan: {error}") from error
    except msgspec.DecodeError as error:
        raise InvalidInput(f"{name} is no JSON: {error}") from error
    if plan.format != FORMAT or plan.format_version != FORMAT_VERSION:
        expected = f"expected {FORMAT} version {FORMAT_VERSION}"
        raise InvalidInput(
            f"{name} is no plan: `$.format` is {plan.format} version {plan.format_version}, {expected}"
        )
    _check(plan, name)
    return plan


def plan_schema() -> dict[str, Any]:
    """The JSON schema of a plan."""
    return msgspec.json.schema(Plan)


def _check(plan: Plan, name: str) -> None:
    """What types cannot say: shapes, and steps that refer to steps before them."""
    count = len(plan.joints)
    _matrix(plan.pose_base_to_world, 4, 4, "$.pose_base_to_world", name)
    if len(plan.q_start) != count:
        raise InvalidInput(
            f"{name} is no plan: `$.q_start` has {len(plan.q_start)} values for {count} joints"
        )
    for i, step in enumerate(plan.steps):
        here = f"$.steps[{i}]"
        _matrix(step.grasp.pose_tool_to_world, 4, 4, f"{here}.grasp.pose_tool_to_world", name)
        _matrix(step.placement.pose_before_to_after, 4, 4, f"{here}.placement.pose_before_to_after", name)
        for k, before in enumerate(step.after):
            if not 0 <= before < i:
                raise InvalidInput(f"{name} is no plan: `{here}.after[{k}]` is {before}, no earlier step")
        for j, segment in enumerate(step.segments):
            if segment.kind not in KINDS:
                raise InvalidInput(
                    f"{name} is no plan: `{here}.segments[{j}].kind` is {segment.kind!r}, "
                    f"expected one of {', '.join(KINDS)}"
                )
            if segment.motion is not None:
                rows = len(segment.motion.times)
                _matrix(segment.motion.positions, rows, count, f"{here}.segments[{j}].motion.positions", name)
                _matrix(
                    segment.motion.velocities, rows, count, f"{here}.segments[{j}].motion.velocities", name
                )
    for i, thing in enumerate(plan.objects):
        for k, part in enumerate(thing.parts):
            _matrix(part, max(len(part), 1), 3, f"$.objects[{i}].parts[{k}]", name)


def _matrix(matrix: Matrix, rows: int, columns: int, where: str, name: str) -> None:
    if len(matrix) != rows:
        raise InvalidInput(f"{name} is no plan: `{where}` has {len(matrix)} rows, expected {rows}")
    for i, row in enumerate(matrix):
        if len(row) != columns:
            raise InvalidInput(f"{name} is no plan: `{where}[{i}]` has {len(row)} values, expected {columns}")
