"""The page of a plan: what the arm will do, on a time line that can be scrubbed, and why in that order."""

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from msgspec import to_builtins

from topple.planner.formats.arm_motion import ArmMotion, Carry, Drive
from topple.planner.formats.plan_format import Plan
from topple.planner.formats.plan_robot import arm_from
from topple.planner.formats.plan_structs import Step
from topple.planner.formats.verification import Verification
from topple.planner.placement.away import BODIES
from topple.planner.report.drawing import Drawing
from topple.planner.report.html import page, table, viewer
from topple.planner.report.limits import LIMITS
from topple.planner.report.played import arm_shape, motion_json
from topple.planner.report.show import dependency_section, photo_section
from topple.planner.report.tables import proof_rows, relation_table, sentence_list
from topple.planner.report.view import Document, Documented, document, object_index, view_data
from topple.planner.report.words import TARGET, UNTIED, millimetres, order_in_words, sentence
from topple.planner.transfer.segments import SegmentKind
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.topology.arguments import checked_arguments
from topple.topology.errors import InvalidInput
from topple.topology.geometry.samples import sampled
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.scene import Scene

Band = tuple[str, float, float]
FREE = (SegmentKind.MOVE, SegmentKind.TRANSFER)
"""Ways that are not meant to come near anything."""


@checked_arguments
def plan_page(
    plan: Plan,
    scene: AnyScene,
    relations: Documented | Document | None = None,
    *,
    arm: Arm | None = None,
    verification: Verification | None = None,
) -> str:
    """Draw a plan as one self-contained HTML page.

    Args:
        plan: The plan.
        scene: What it was made for, or the path of it.
        relations: What `relate` found in the scene; found anew where None.
        arm: The arm; found by what the plan says of it where None.
        verification: What `Plan.verify` found, if it was asked.

    Returns:
        The page: the arm and what it carries move along a time line in a 3-D view to turn and zoom; beside it
        every step with its reason, grasp, place and proven clearance.

    Raises:
        InvalidInput: The plan names what is not in the scene, or its arm is not here.
    """
    scene = as_scene(scene)
    if relations is None:
        from topple.topology.relations import relate

        relations = relate(scene)
    check_scene(plan, scene)
    if arm is None:
        if plan.arm is None:
            raise InvalidInput(f"the plan does not say where its arm {plan.robot!r} is described: give arm")
        arm = arm_from(plan.arm, plan.robot)
    return _PlanPage(plan, scene, document(relations), arm, verification).build()


def check_scene(plan: Plan, scene: Scene) -> None:
    """Refuse a plan of another scene.

    Raises:
        InvalidInput: It moves what is not in the scene.
    """
    missing = sorted({step.object for step in plan.steps} - set(scene.names))
    if missing:
        raise InvalidInput(
            f"the plan moves {', '.join(missing)}, which the scene has not: give the plan's own scene"
        )


def plan_motion(plan: Plan, arm: Arm) -> ArmMotion | None:
    """Key frames of a whole plan: None where nothing moves."""
    base, up = np.array(plan.pose_base_to_world), np.array(plan.up)
    return ArmMotion.of(arm, base, [_carry(step, up) for step in plan.steps])


def _carry(step: Step, up: Any) -> Carry:
    drives: list[Drive] = []
    for segment in step.segments:
        motion, hand = segment.motion, ToolState(segment.hand.opening, segment.hand.cup_extension)
        times = np.array([] if motion is None else motion.times)
        positions = np.array([] if motion is None else motion.positions)
        drives.append(Drive(segment.kind, segment.tool, hand, times, positions))
    return Carry(drives, [held.object for held in step.attachments], -step.placement.drop * up)


class _PlanPage:
    """What the parts of the page share."""

    def __init__(
        self, plan: Plan, scene: Scene, relations: Document, arm: Arm, verification: Verification | None
    ) -> None:
        self.plan, self.scene, self.relations, self.verification = plan, scene, relations, verification
        self.drawing = Drawing.of(scene)
        for thing in plan.objects:
            if thing.name in BODIES.values():  # stood there for the plan: cameras saw none of it
                parts = [np.array(part) for part in thing.parts]
                self.drawing = self.drawing.beside(thing.name, sampled(parts, LIMITS.parts))
        self.index = object_index(self.drawing)
        self.shape = arm_shape(arm.parts)
        self.motion = plan_motion(plan, arm)
        self.order: Document = {
            "order": plan.order,
            "targets": [step.object for step in plan.steps if step.action != "remove"],
            "dependencies": to_builtins(plan.dependencies),
        }

    def build(self) -> str:
        plan, bands = self.plan, self.bands()
        told = None
        if self.motion is not None:
            told = motion_json(self.motion, self.shape, self.index, self.drawing.centre, bands)
        body = self.head(bands) + '<main class="columns"><div>'
        body += viewer(0, ordered=True, motion=bands if told else None)
        body += dependency_section(self.scene, self.drawing, self.order) + "</div><div>"
        body += "<h2>Steps</h2>" + self.steps() + self.checked()
        body += photo_section(self.scene, self.drawing, self.order)
        body += "<h2>Relations</h2>" + relation_table(self.relations, self.index)
        body += sentence_list(list(dict.fromkeys(plan.assumptions)), "Assumptions") + "</div></main>"
        view = view_data(self.drawing, self.relations, self.order, None, told)
        return page(
            f"topple: plan to {plan.goal}",
            body,
            {"views": [view], "arm": self.shape},
            ["viewer.js", "motion.js", "page.js", "show.js"],
        )

    def bands(self) -> list[Band]:
        """Each step, from when and until when [s]."""
        if self.motion is None:
            return []
        ends = [float(self.motion.times[last]) for last in self.motion.ends]
        names = [f"{number}. {step.object}" for number, step in enumerate(self.plan.steps, start=1)]
        return [
            (name, *span) for name, span in zip(names, zip([0.0, *ends], ends, strict=False), strict=False)
        ]

    def head(self, bands: Sequence[Band]) -> str:
        plan = self.plan
        x, y, z = (row[3] for row in plan.pose_base_to_world[:3])
        where = "base searched" if plan.base_searched else "base given"
        facts = [
            f"{len(plan.steps)} step{'' if len(plan.steps) == 1 else 's'}",
            f"{plan.seconds:.1f} s of motion" + (f", {bands[-1][2]:.1f} s with the hand's" if bands else ""),
            "every motion certified" if plan.certified else "not every motion certified",
            f"{plan.robot} at {x:.2f} {y:.2f} {z:.2f} m ({where})",
            f"seed {plan.seed}",
        ]
        refuted = self.verification is not None and not self.verification.ok
        word = "refuted by its own check" if refuted else "planned"
        kind = "bad" if refuted or not plan.certified else "good"
        marks = "".join(
            f'<li><button type="button" data-time="{since}"><b>{escape(name)}</b>'
            f"<span>{escape(step.action)}</span></button></li>"
            for (name, since, _), step in zip(bands, plan.steps, strict=False)
        )
        return (
            f'<header><h1>{escape(plan.goal)}: <span class="{kind}">{word}</span></h1>'
            f'<p class="lead">{escape(", ".join(facts))}.</p></header><ol class="timeline">{marks}</ol>'
        )

    def steps(self) -> str:
        told = [text for _, text in order_in_words(self.order)]
        items = "".join(
            f'<li data-object="{self.index.get(step.object, -1)}" tabindex="0">'
            f'<b class="name">{escape(step.object)}</b>: '
            f"{escape(sentence(step.reason) if text in (f'{UNTIED}.', f'{TARGET}.') else text)}"
            f'<span class="kind">{escape(_how(step))}</span></li>'
            for step, text in zip(self.plan.steps, told, strict=True)
        )
        return f'<ol class="order steps">{items}</ol>' if items else "<p>There is nothing to do.</p>"

    def checked(self) -> str:
        """What its own check by other means found."""
        found = self.verification
        if found is None:
            return ""
        html = "<h2>Verification</h2>"
        if found.ok:
            html += (
                f'<p class="good">Verified: {len(found.residuals)} checks at {found.states} states, by other '
                "means than it was planned with.</p>"
            )
        else:
            items = "".join(
                f"<li>{escape(bad.name)}: {bad.value:.2g} {escape(bad.unit)}, {escape(bad.witness)}</li>"
                for bad in found.failed
            )
            count = f"{len(found.failed)} of {len(found.residuals)}"
            html += f'<p class="bad">{count} checks failed.</p><ul>{items}</ul>'
        rows = "".join(
            f"<tr><td>{escape(what)}</td><td>{escape(means)}</td><td>{escape(steps)}</td></tr>"
            for what, means, steps in proof_rows(found)
        )
        shown = table(("what", "by", "steps"), rows)
        return f"{html}<details><summary>What is shown by which means</summary>{shown}</details>"


def _how(step: Step) -> str:
    """Grasp, place, clearance and time of a step, in words."""
    seconds = sum(segment.motion.times[-1] for segment in step.segments if segment.motion is not None)
    free = [segment.clearance for segment in step.segments if segment.certified and segment.kind in FREE]
    parts = [f"{step.grasp.kind} grasp", f"{step.placement.words}, {step.placement.rest}".rstrip(", ")]
    if step.placement.drop > 5e-4:
        parts.append(f"let go {millimetres(step.placement.drop)} above its place")
    if free:
        parts.append(f"proven to stay {millimetres(min(free))} clear of everything between")
    parts.append(f"{seconds:.1f} s of motion")
    parts += [f"fallback: {name}" for name in step.fallbacks]
    return "; ".join(parts) + "."
