"""A plan: what it is made of, checked as it is read, and verified by other means than it was made with."""

from collections.abc import Iterator, Mapping, Sequence
from inspect import cleandoc
from math import hypot
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from topple.planner.decide.goal import Action, PlaceRelation
from topple.planner.fallbacks import Relaxation
from topple.planner.formats.plan_structs import FORMAT, FORMAT_VERSION, Matrix, PlanData, as_array, as_lists
from topple.planner.placement.away import BODIES, Away
from topple.planner.transfer.segments import Segment
from topple.planner.verify.verification import Verification
from topple.planner.verify.verify import verify
from topple.robots.arm.arm import Arm
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_pose
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import write_whole
from topple.topology.base.tolerances import FARTHEST, RIGID
from topple.topology.io.limits import read_given
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.io.strict_json import read_json


class Plan(PlanData, frozen=True, kw_only=True):  # noqa: D101 - what its data say, in the schema too
    __doc__ = f"""{PlanData.__doc__}
    Examples:
        >>> made = plan(scene, "free cup", "panda")
        >>> made.order, made.steps[0].grasp.kind, made.certified
        (['cup'], 'pinch', True)
    """

    @checked_arguments
    def verify(self, scene: AnyScene | None = None, robot: Arm | str | None = None) -> Verification:
        """Check everything again by other means than it was planned with.

        Args:
            scene: What the plan was made for; without it what needs clouds is not evaluated.
            robot: The arm; found again by what the plan says of it where None.

        Returns:
            Residuals: at most 0 where all is well, `inf` where not evaluated; see `topple.planner.verify`.

        Raises:
            InvalidInput: The plan does not fit the arm or the scene.
        """
        return verify(self, None if scene is None else as_scene(scene), robot)

    def to_json(self) -> dict[str, Any]:
        """The plan as a `topple.plan` document."""
        return msgspec.to_builtins(self, enc_hook=as_lists)

    @staticmethod
    def from_json(document: Mapping[str, Any] | str | bytes) -> "Plan":
        """Read a plan from a document, or its text.

        Raises:
            InvalidInput: It is no plan; the message has the path of the bad field.
        """
        text = document if isinstance(document, (str, bytes)) else msgspec.json.encode(document)
        return plan_from_json(text, "the document")

    @checked_arguments
    def save(self, path: str | Path) -> None:
        """Write the plan as a JSON file, whole or not at all.

        Raises:
            InvalidInput: The file cannot be written.
        """
        write_whole(path, plan_to_json(self) + b"\n")

    @staticmethod
    def load(path: str | Path) -> "Plan":
        """Read the file of a plan.

        Raises:
            InvalidInput: It cannot be read, or is no plan.
        """
        return plan_from_json(read_given(Path(path), str(path)), str(path))


def plan_to_json(plan: Plan) -> bytes:
    """Write a plan.

    Args:
        plan: The plan.

    Returns:
        UTF-8 JSON.
    """
    return msgspec.json.encode(plan, enc_hook=as_lists)


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
    document = read_json(data, name)
    try:
        plan = msgspec.convert(document, Plan, str_keys=True, dec_hook=as_array)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"{name} is no plan: {error}") from error
    if plan.format != FORMAT or plan.format_version != FORMAT_VERSION:
        expected = f"expected {FORMAT} version {FORMAT_VERSION}"
        raise InvalidInput(
            f"{name} is no plan: `$.format` is {plan.format} version {plan.format_version}, {expected}"
        )
    for fault in _faults(plan):
        raise InvalidInput(f"{name} is no plan: {fault}")
    return plan


def plan_schema() -> dict[str, Any]:
    """The JSON schema (2020-12) of a plan, as `docs/plan.schema.json` has it."""
    made = msgspec.json.schema(Plan, schema_hook=lambda _: {"type": "array"})
    for part in made["$defs"].values():
        if "description" in part:  # as msgspec itself has it from 0.23 on
            part["description"] = cleandoc(part["description"])
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | made


def _faults(plan: Plan) -> Iterator[str]:
    """Find faults that types cannot exclude: in shapes, object names, words, references to other steps."""
    count, away = len(plan.joints), plan.away
    names = {thing.name for thing in plan.objects}
    known = f"its objects are {', '.join(sorted(names)) or 'nothing'}"
    yield from _pose(plan.pose_base_to_world, "$.pose_base_to_world")
    if len(plan.q_start) != count:
        yield f"`$.q_start` has {len(plan.q_start)} values for {count} joints"
    if abs(hypot(*plan.up) - 1.0) > RIGID:
        yield f"`$.up` is {list(plan.up)}, expected a direction of length 1"
    yield from _twice([thing.name for thing in plan.objects], "$.objects", "has a name twice")
    for thing, pose in plan.poses.items():
        yield from _pose(pose, f"$.poses.{thing}")
    for key, which in (("poses", plan.poses), ("upright", plan.upright), ("clamped", plan.clamped)):
        yield from (f"`$.{key}` has {odd!r}, {known}" for odd in sorted({*which} - names))
    for i, tool in enumerate(plan.arm.tools if plan.arm is not None else []):
        yield from _pose(tool.pose_tool_to_link, f"$.arm.tools[{i}].pose_tool_to_link")
    if away is not None:
        yield from _pose(away.pose_to_world, "$.away.pose_to_world")
        yield from _other([away.how], tuple(Away)[1:], "$.away.how")
        yield from _matrix([away.size], 1, 3, "$.away.size")
        if away.how in BODIES and BODIES[Away(away.how)] not in names:
            yield f"`$.objects` lacks {BODIES[Away(away.how)]!r}"
    places = ("", *PlaceRelation, *([away.how] if away else []))
    for i, step in enumerate(plan.steps):
        here, place = f"$.steps[{i}]", step.placement
        held = [each.object for each in step.attachments]
        yield from _pose(step.grasp.pose_tool_to_world, f"{here}.grasp.pose_tool_to_world")
        yield from _pose(place.pose_before_to_after, f"{here}.placement.pose_before_to_after")
        said = [("object", step.object), ("placement.into", place.into or step.object)]
        said += [(f"attachments[{k}].object", name) for k, name in enumerate(held)]
        yield from (f"`{here}.{key}` is {name!r}, {known}" for key, name in said if name not in names)
        if place.how in tuple(PlaceRelation) and place.into in (None, step.object):
            yield f"`{here}.placement.how` is given, and no other thing `into`"
        for k, each in enumerate(step.attachments):
            yield from _pose(each.pose_start_to_tool, f"{here}.attachments[{k}].pose_start_to_tool")
        yield from _twice(step.after, f"{here}.after", "names one twice")
        yield from _twice(held, f"{here}.attachments", "names one twice")
        yield from _other([place.how], places, f"{here}.placement.how")
        yield from _other([step.action], tuple(Action), f"{here}.action")
        yield from _other(step.fallbacks, tuple(Relaxation), f"{here}.fallbacks")
        for k, before in enumerate(step.after):
            if not 0 <= before < i:
                yield f"`{here}.after[{k}]` is {before}, no earlier step"
        for j, segment in enumerate(step.segments):
            yield from _segment(segment, count, f"{here}.segments[{j}]")
    for i, thing in enumerate(plan.objects):
        if not thing.parts:
            yield f"`$.objects[{i}].parts` is empty, expected convex parts"
        for key, parts in (("parts", thing.parts), ("whole", thing.whole)):
            for k, part in enumerate(parts):
                yield from _matrix(part, max(len(part), 1), 3, f"$.objects[{i}].{key}[{k}]")


def _segment(segment: Segment, joints: int, here: str) -> Iterator[str]:
    if any(one == other for one, other in segment.may_touch):
        yield f"`{here}.may_touch` has a name with itself"
    if segment.motion is not None:
        rows = len(segment.motion.times)
        if rows == 0:
            yield f"`{here}.motion.times` is empty"
        yield from _matrix(segment.motion.positions, rows, joints, f"{here}.motion.positions")
        yield from _matrix(segment.motion.velocities, rows, joints, f"{here}.motion.velocities")


def _twice(which: Sequence[object], where: str, words: str) -> Iterator[str]:
    if len({*which}) < len(which):
        yield f"`{where}` {words}, expected each once"


def _other(which: Sequence[str], words: Sequence[str], where: str) -> Iterator[str]:
    for odd in (word for word in which if word not in words):
        yield f"`{where}` has {odd!r}, expected one of {', '.join(filter(None, words))}"


def _pose(matrix: Matrix, where: str) -> Iterator[str]:
    yield from _matrix(matrix, 4, 4, where)
    try:
        as_pose(matrix, f"`{where}`")
    except InvalidInput as error:
        yield str(error)


def _matrix(matrix: Matrix | FloatArray, rows: int, columns: int, where: str) -> Iterator[str]:
    if len(matrix) != rows:
        yield f"`{where}` has {len(matrix)} rows, expected {rows}"
    for i, row in enumerate(matrix):
        if len(row) != columns:
            yield f"`{where}[{i}]` has {len(row)} values, expected {columns}"
        if not (np.abs(row) <= FARTHEST).all():
            yield f"`{where}[{i}]` has a value that is not finite, or beyond {FARTHEST:g}"
