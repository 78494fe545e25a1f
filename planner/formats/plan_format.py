"""A plan: what it is made of, checked as it is read, and verified by other means than it was made with."""

from collections.abc import Mapping
from math import hypot
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from topple.planner.decide.goal import Action, PlaceRelation
from topple.planner.fallbacks import Fallback
from topple.planner.formats.plan_structs import FORMAT, FORMAT_VERSION, Matrix, PlanData
from topple.planner.formats.verification import Verification
from topple.planner.placement.away import BODIES, Away
from topple.planner.transfer.segments import KINDS
from topple.planner.verify.verify import verify
from topple.robots.arm.arm import Arm
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.checks import as_pose
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import write_whole
from topple.topology.base.tolerances import FARTHEST, RIGID
from topple.topology.io.limits import read_bytes
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.io.strict_json import read_json


class Plan(PlanData, frozen=True, kw_only=True):  # noqa: D101 - what its data say, in the schema too
    __doc__ = PlanData.__doc__

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
        return msgspec.to_builtins(self)

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
        try:
            return plan_from_json(read_bytes(Path(path), str(path)), str(path))
        except OSError as error:
            raise InvalidInput(f"{path}: cannot be read, {error.strerror}") from error


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
    document = read_json(data, name)
    try:
        plan = msgspec.convert(document, Plan, str_keys=True)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"{name} is no plan: {error}") from error
    if plan.format != FORMAT or plan.format_version != FORMAT_VERSION:
        expected = f"expected {FORMAT} version {FORMAT_VERSION}"
        raise InvalidInput(
            f"{name} is no plan: `$.format` is {plan.format} version {plan.format_version}, {expected}"
        )
    _check(plan, name)
    return plan


def plan_schema() -> dict[str, Any]:
    """The JSON schema (2020-12) of a plan, as `docs/plan.schema.json` has it."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | msgspec.json.schema(Plan)


def _check(plan: Plan, name: str) -> None:
    """What types cannot say: shapes, and steps that refer to steps before them."""
    count = len(plan.joints)
    _pose(plan.pose_base_to_world, "$.pose_base_to_world", name)
    if len(plan.q_start) != count:
        raise InvalidInput(
            f"{name} is no plan: `$.q_start` has {len(plan.q_start)} values for {count} joints"
        )
    if abs(hypot(*plan.up) - 1.0) > RIGID:
        raise InvalidInput(f"{name} is no plan: `$.up` is {list(plan.up)}, expected a direction of length 1")
    names = {thing.name for thing in plan.objects}
    if len(names) < len(plan.objects):
        raise InvalidInput(f"{name} is no plan: `$.objects` has a name twice, expected each once")
    for thing, pose in plan.poses.items():
        _pose(pose, f"$.poses.{thing}", name)
    for key, which in (("poses", plan.poses), ("upright", plan.upright), ("clamped", plan.clamped)):
        if odd := sorted({*which} - names):
            known = ", ".join(sorted(names)) or "nothing"
            raise InvalidInput(f"{name} is no plan: `$.{key}` has {odd[0]!r}, its objects are {known}")
    for i, tool in enumerate(plan.arm.tools if plan.arm is not None else []):
        _pose(tool.pose_tool_to_link, f"$.arm.tools[{i}].pose_tool_to_link", name)
    if plan.away is not None:
        _pose(plan.away.pose_to_world, "$.away.pose_to_world", name)
        if plan.away.how not in tuple(Away)[1:]:
            known = ", ".join(tuple(Away)[1:])
            raise InvalidInput(
                f"{name} is no plan: `$.away.how` is {plan.away.how!r}, expected one of {known}"
            )
        _matrix([plan.away.size], 1, 3, "$.away.size", name)
        if plan.away.how in BODIES and BODIES[Away(plan.away.how)] not in names:
            raise InvalidInput(f"{name} is no plan: `$.objects` lacks {BODIES[Away(plan.away.how)]!r}")
    for i, step in enumerate(plan.steps):
        here = f"$.steps[{i}]"
        _pose(step.grasp.pose_tool_to_world, f"{here}.grasp.pose_tool_to_world", name)
        _pose(step.placement.pose_before_to_after, f"{here}.placement.pose_before_to_after", name)
        told = [("object", step.object), ("placement.into", step.placement.into or step.object)]
        told += [(f"attachments[{k}].object", held.object) for k, held in enumerate(step.attachments)]
        for key, which in told:
            if which not in names:
                known = ", ".join(sorted(names)) or "nothing"
                raise InvalidInput(f"{name} is no plan: `{here}.{key}` is {which!r}, its objects are {known}")
        if step.placement.how in tuple(PlaceRelation) and step.placement.into in (None, step.object):
            raise InvalidInput(
                f"{name} is no plan: `{here}.placement.how` is given, and no other thing `into`"
            )
        for k, held in enumerate(step.attachments):
            _pose(held.pose_start_to_tool, f"{here}.attachments[{k}].pose_start_to_tool", name)
        for key, values in (
            ("after", step.after),
            ("attachments", [held.object for held in step.attachments]),
        ):
            if len({*values}) < len(values):
                raise InvalidInput(f"{name} is no plan: `{here}.{key}` names one twice, expected each once")
        for key, words, which in (
            (
                "placement.how",
                ("", *PlaceRelation, *([plan.away.how] if plan.away else [])),
                [step.placement.how],
            ),
            ("action", tuple(Action), [step.action]),
            ("fallbacks", tuple(Fallback), step.fallbacks),
        ):
            if odd := [word for word in which if word not in words]:
                known = ", ".join(filter(None, words))
                raise InvalidInput(
                    f"{name} is no plan: `{here}.{key}` has {odd[0]!r}, expected one of {known}"
                )
        for k, before in enumerate(step.after):
            if not 0 <= before < i:
                raise InvalidInput(f"{name} is no plan: `{here}.after[{k}]` is {before}, no earlier step")
        for j, segment in enumerate(step.segments):
            if segment.kind not in KINDS:
                raise InvalidInput(
                    f"{name} is no plan: `{here}.segments[{j}].kind` is {segment.kind!r}, "
                    f"expected one of {', '.join(KINDS)}"
                )
            if any(one == other for one, other in segment.may_touch):
                raise InvalidInput(
                    f"{name} is no plan: `{here}.segments[{j}].may_touch` has a name with itself"
                )
            if segment.motion is not None:
                rows = len(segment.motion.times)
                if rows == 0:
                    raise InvalidInput(f"{name} is no plan: `{here}.segments[{j}].motion.times` is empty")
                _matrix(segment.motion.positions, rows, count, f"{here}.segments[{j}].motion.positions", name)
                _matrix(
                    segment.motion.velocities, rows, count, f"{here}.segments[{j}].motion.velocities", name
                )
    for i, thing in enumerate(plan.objects):
        if not thing.parts:
            raise InvalidInput(f"{name} is no plan: `$.objects[{i}].parts` is empty, expected convex parts")
        for key, parts in (("parts", thing.parts), ("whole", thing.whole)):
            for k, part in enumerate(parts):
                _matrix(part, max(len(part), 1), 3, f"$.objects[{i}].{key}[{k}]", name)


def _pose(matrix: Matrix, where: str, name: str) -> None:
    _matrix(matrix, 4, 4, where, name)
    try:
        as_pose(matrix, f"`{where}`")
    except InvalidInput as error:
        raise InvalidInput(f"{name} is no plan: {error}") from error


def _matrix(matrix: Matrix, rows: int, columns: int, where: str, name: str) -> None:
    if len(matrix) != rows:
        raise InvalidInput(f"{name} is no plan: `{where}` has {len(matrix)} rows, expected {rows}")
    for i, row in enumerate(matrix):
        if len(row) != columns:
            raise InvalidInput(f"{name} is no plan: `{where}[{i}]` has {len(row)} values, expected {columns}")
        if not (np.abs(row) <= FARTHEST).all():
            raise InvalidInput(
                f"{name} is no plan: `{where}[{i}]` has a value that is not finite, or beyond {FARTHEST:g}"
            )
