"""The page of a plan: what the arm will do, on a time line that can be scrubbed, and why in that order."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
from msgspec import to_builtins

from topple.planner.decide.names import spoken
from topple.planner.decide.words import TARGET, UNTIED, millimetres, number_of, order_rows, sentence
from topple.planner.formats.arm_motion import ArmMotion
from topple.planner.formats.plan_robot import arm_from
from topple.planner.formats.plan_structs import Step
from topple.planner.placement.away import BODIES
from topple.planner.planning.plan_format import Plan
from topple.planner.report.drawing import Document, Documented, Drawing, document, view_data
from topple.planner.report.html import Span, bullets, fold, glance, plain_table, view_page
from topple.planner.report.limits import LIMITS
from topple.planner.report.photo import photo
from topple.planner.report.played import arm_shape, motion_json
from topple.planner.report.show import dependency_section, with_look
from topple.planner.report.tables import proof_rows, relation_table, sentence_list
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.verification import Verification
from topple.robots.arm.arm import Arm
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.samples import sample
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.scene.scene import Scene

FREE = (SegmentKind.MOVE, SegmentKind.TRANSFER)  # ways that are not meant to come near anything


@checked_arguments
def plan_page(
    plan: Plan,
    scene: AnyScene,
    relations: Documented | Document | None = None,
    *,
    arm: Arm | None = None,
    verification: Verification | None = None,
) -> str:
    """Draw a plan as one self-contained HTML page: the arm's motion on a time line, and every step.

    Args:
        plan: The plan.
        scene: What it was made for, or the path of it.
        relations: What `relate` found in the scene; found anew where None.
        arm: The arm; found by what the plan says of it where None.
        verification: What `Plan.verify` found, if it was asked.

    Raises:
        InvalidInput: The plan names what is not in the scene, or its arm is not here.

    Examples:
        >>> made = plan(scene, "free cup", "panda")
        >>> plan_page(made, scene)[:15]
        '<!doctype html>'
    """
    scene = as_scene(scene)
    if relations is None:
        from topple.topology.relations.relate import relate

        relations = relate(scene)
    check_scene(plan, scene)
    whole = scene, plan, document(relations), verification
    scene, plan, found, verification = spoken(scene, whole)
    if arm is None:
        if plan.arm is None:
            raise InvalidInput(f"the plan does not say where its arm {plan.robot!r} is described: give arm")
        arm = arm_from(plan.arm, plan.robot)
    drawing = Drawing.of(scene)
    for thing in plan.objects:
        if thing.name in BODIES.values():  # stood there for the plan: cameras saw none of it
            parts = [np.array(part) for part in thing.parts]
            drawing = drawing.beside(thing.name, sample(parts, LIMITS.parts))
    shape, motion, order, bands, told = arm_shape(arm), plan_motion(plan, arm), order_of(plan), [], None
    if motion is not None:
        ends = [float(motion.times[last]) for last in motion.ends]
        named = enumerate(zip(plan.steps, [0.0, *ends], ends, strict=False), start=1)
        bands = [(f"{number}. {step.object}", since, until) for number, (step, since, until) in named]
        told = motion_json(motion, shape, drawing.index, drawing.centre, bands)
    order = with_look(scene, order)
    steps = f"<h2>Steps</h2>{step_list(plan, order, drawing.index)}"
    top = _head(plan, bands, refuted=verification is not None and not verification.ok)
    top += glance(photo(scene, drawing, order), steps, dependency_section(scene, drawing, order))
    right = _check_words(verification) + fold("Relations", relation_table(found, drawing.index))
    right += sentence_list(list(dict.fromkeys(plan.assumptions)), "Assumptions")
    view = view_data(drawing, found, order, None, told)
    return view_page(f"topple: plan to {plan.goal}", top, view, ("", right), arm=shape)


def check_scene(plan: Plan, scene: Scene) -> None:
    """Refuse a plan that moves what is not in a scene, by an `InvalidInput`."""
    if missing := ", ".join(sorted({step.object for step in plan.steps} - set(scene.names))):
        raise InvalidInput(f"the plan moves {missing}, which the scene has not: give the plan's own scene")


def plan_motion(plan: Plan, arm: Arm) -> ArmMotion | None:
    """Key frames of a whole plan: None where nothing moves."""
    base, up = np.array(plan.pose_base_to_world), np.array(plan.up)
    carries = [
        (step.segments, [held.object for held in step.attachments], -step.placement.drop * up)
        for step in plan.steps
    ]
    return ArmMotion.of(arm, base, carries)


def _head(plan: Plan, bands: Sequence[Span], *, refuted: bool) -> str:
    x, y, z = (row[3] for row in plan.pose_base_to_world[:3])
    where = "searched" if plan.base_searched else "given"
    facts = [
        number_of(len(plan.steps), "step"),
        f"{plan.seconds:.1f} s of motion" + (f", {bands[-1][2]:.1f} s with the hand's" if bands else ""),
        f"{'every' if plan.certified else 'not every'} motion certified",
        f"{plan.robot} at {x:.2f} {y:.2f} {z:.2f} m (base {where})",
        f"seed {plan.seed}",
    ]
    kind = "bad" if refuted or not plan.certified else "good"
    marks = "".join(
        f'<li><button type="button" data-time="{since}"><b>{escape(name)}</b>'
        f"<span>{escape(step.action)}</span></button></li>"
        for (name, since, _), step in zip(bands, plan.steps, strict=False)
    )
    return (
        f'<header><h1>{escape(plan.goal)}: <span class="{kind}">'
        f"{'refuted by its own check' if refuted else 'planned'}</span></h1>"
        f'<p class="lead">{escape(", ".join(facts))}.</p></header><ol class="timeline">{marks}</ol>'
    )


def _check_words(found: Verification | None) -> str:
    """Sum up the plan's own check by other means."""
    if found is None:
        return ""
    count = len(found.residuals)
    if found.ok:
        said = f"Verified: {count} checks at {found.states} states, by other means than it was planned with."
        html = f'<p class="good">{said}</p>'
    else:
        html = f'<p class="bad">{len(found.failed)} of {count} checks failed.</p>' + bullets(
            [f"{bad.name}: {bad.value:.2g} {bad.unit}, {bad.witness}" for bad in found.failed]
        )
    shown = fold("What is shown by which means", plain_table(("what", "by", "steps"), proof_rows(found)))
    return f"<h2>Verification</h2>{html}{shown}"


def order_of(plan: Plan) -> Document:
    """Make an order's document of a plan."""
    targets = [step.object for step in plan.steps if step.action != "remove"]
    return {"order": plan.order, "targets": targets, "dependencies": to_builtins(plan.dependencies)}


def step_list(plan: Plan, order: Document, index: Mapping[str, int]) -> str:
    """The steps of a plan with their reasons as HTML."""
    told = [text for _, _, text, _ in order_rows(order)]
    items = "".join(
        f'<li data-object="{index.get(step.object, -1)}" tabindex="0">'
        f'<b class="name">{escape(step.object)}</b>: '
        f"{escape(_reason(step, text))}"
        f'<span class="kind">{escape(_how(step))}</span></li>'
        for step, text in zip(plan.steps, told, strict=False)
    )
    return f'<ol class="order steps">{items}</ol>' if items else "<p>There is nothing to do.</p>"


def _reason(step: Step, told: str) -> str:
    """Why a step is done: what the plan knows of it where an order says that nothing ties it."""
    bare = next((each for each in (f"{UNTIED}.", f"{TARGET}.") if told.startswith(each)), "")
    return f"{sentence(step.reason)}{told.removeprefix(bare)}" if bare else told


def _how(step: Step) -> str:
    """Grasp, place, clearance and time of a step, in words."""
    seconds = sum(segment.seconds for segment in step.segments)
    free = [segment.clearance for segment in step.segments if segment.certified and segment.kind in FREE]
    parts = [f"{step.grasp.kind} grasp", f"{step.placement.words}, {step.placement.rest}".rstrip(", ")]
    if step.placement.drop > 5e-4:
        parts.append(f"let go {millimetres(step.placement.drop)} above its place")
    if free:
        parts.append(f"proven to stay {millimetres(min(free))} clear of everything between")
    parts.append(f"{seconds:.1f} s of motion")
    parts += [f"fallback: {name}" for name in step.fallbacks]
    return "; ".join(parts) + "."
