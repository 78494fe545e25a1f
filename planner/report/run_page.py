"""The page of a closed-loop run: a timeline, and for each step what was seen, done and disturbed."""

import base64
import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from topple.planner.formats.pictures import as_jpeg, picture
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.report.drawing import Drawing
from topple.planner.report.html import page, table, viewer
from topple.planner.report.limits import LIMITS
from topple.planner.report.played import arm_shape, motion_json, spans
from topple.planner.report.show import dependency_section, photo_section
from topple.planner.report.tables import Change, order_list, relation_changes, relation_table
from topple.planner.report.view import object_index, view_data
from topple.planner.report.words import millimetres, sentence
from topple.planner.tolerances import DISTURBED, HIT, TURNED
from topple.topology.arguments import checked_arguments
from topple.topology.scene import Scene

__all__ = ["picture", "run_page"]

Document = Mapping[str, Any]
_NO_RELATIONS: Document = {"relations": ()}


@checked_arguments
def run_page(
    record: RunRecord, *, points: int = LIMITS.run_points, photos: bool = True, compact: bool = False
) -> str:
    """Draw a run as one self-contained HTML page.

    Args:
        record: The run. Whatever a step lacks (pictures, scene, order) is left out of the page.
        points: Points that may be drawn in all.
        photos: Whether what the cameras saw is shown.
        compact: Without margins, for a notebook's cell.

    Returns:
        The page; steps are turned by the timeline, the buttons or the arrow keys.
    """
    return _RunPage(record, points, photos).build(compact)


class _RunPage:
    """Collects pictures and views while the steps are written; each picture is embedded once."""

    def __init__(self, record: RunRecord, points: int, photos: bool) -> None:
        self.record, self.photos = record, photos
        self.pictures: dict[bytes, int] = {}
        self.views: list[dict[str, Any]] = []
        scenes = sum(step.scene is not None for step in record.steps) + (record.scene is not None)
        self.arm = arm_shape(record.arm_parts)
        self.points = min(LIMITS.page_points, points // max(scenes, 1))

    def build(self, compact: bool) -> str:
        record = self.record
        sections = [self.step(number, step) for number, step in enumerate(record.steps, start=1)]
        sections.append(self.end())
        body = _head(record) + _timeline(record) + f"<main>{''.join(sections)}</main>"
        pictures = [base64.b64encode(as_jpeg(data)).decode("ascii") for data in self.pictures]
        return page(
            f"topple: {record.goal}",
            body,
            {"views": self.views, "pictures": pictures, "arm": self.arm},
            ["viewer.js", "motion.js", "page.js", "run.js"],
            compact=compact,
        )

    def step(self, number: int, step: StepRecord) -> str:
        title = f"Step {number} of {len(self.record.steps)}: {_deed(step)}"
        html = f'<section class="step">{_turns(title)}'
        html += f"<p>{escape(sentence(step.reason))}</p>" if step.reason else ""
        if step.events:
            html += f"<ul>{''.join(f'<li>{escape(sentence(text))}</li>' for text in step.events)}</ul>"
        html += _facts(step)
        drawing = None if step.scene is None else Drawing.of(step.scene, self.points)
        html += self.picture_pair(step, drawing)
        html += (
            '<div class="columns even"><div>'
            + _disturbed(step)
            + "</div><div>"
            + _predictions(step)
            + "</div></div>"
        )
        html += self.seen(
            drawing,
            step.scene,
            step.relations,
            step.order,
            step,
            "Seen before this step, and what the arm did",
        )
        return html + "</section>"

    def end(self) -> str:
        record = self.record
        html = f'<section class="step">{_turns("End: the goal is " + record.verdict)}'
        if record.violations:
            items = "".join(f"<li>{escape(text)}</li>" for text in record.violations)
            html += f'<h2 class="bad">Violations</h2><ul>{items}</ul>'
        else:
            html += "<p>No violation: nothing the plan does not handle was disturbed.</p>"
        if record.notes:
            html += (
                "<h2>Notes</h2><ul>" + "".join(f"<li>{escape(note)}</li>" for note in record.notes) + "</ul>"
            )
        drawing = None if record.scene is None else Drawing.of(record.scene, self.points)
        html += self.seen(drawing, record.scene, record.relations, record.order, None, "Seen at the end")
        return html + "</section>"

    def picture_pair(self, step: StepRecord, drawing: Drawing | None) -> str:
        """What a camera saw before, its masks outlined, and after."""
        if not self.photos:
            return ""
        before = (
            ""
            if drawing is None or step.scene is None
            else photo_section(step.scene, drawing, step.order, step.photo)
        )
        shown = (before or self.plain(step.picture_before, "before")) + self.plain(
            step.picture_after, "after"
        )
        return f'<div class="pictures">{shown}</div>' if shown else ""

    def plain(self, data: bytes | None, when: str) -> str:
        if not data:
            return ""
        return (
            f'<figure><img data-picture="{self.number(data)}" alt="camera, {when}">'
            f'<figcaption class="note">{when.capitalize()}</figcaption></figure>'
        )

    def number(self, data: bytes) -> int:
        """Number of a picture; the view after a step is often the one before the next."""
        return self.pictures.setdefault(data, len(self.pictures))

    def seen(
        self,
        drawing: Drawing | None,
        scene: Scene | None,
        relations: Document | None,
        order: Document | None,
        step: StepRecord | None,
        title: str,
    ) -> str:
        """View, relations, graph and order of one moment."""
        if scene is None or drawing is None:
            return ""
        index = object_index(drawing)
        path, motion = (None, None) if step is None else (step.tool_path, step.motion)
        shown = motion if self.arm else None
        told = None if shown is None else motion_json(shown, self.arm, index, drawing.centre)
        self.views.append(view_data(drawing, relations or _NO_RELATIONS, order, path, told))
        moved = path is not None and len(path) > 0
        html = f'<h2>{escape(title)}</h2><div class="columns"><div>'
        html += viewer(
            len(self.views) - 1,
            ordered=order is not None,
            path=moved,
            motion=None if shown is None else spans(shown),
        )
        html += dependency_section(scene, drawing, order) if order is not None else ""
        html += "</div><div>"
        html += "<h2>Order from here</h2>" + order_list(order, index) if order is not None else ""
        html += "<h2>Relations</h2>" + relation_table(relations, index) if relations is not None else ""
        return html + "</div></div>"


def _disturbed_by(step: StepRecord) -> list[str]:
    """What moved, turned or was hit by more than what is not handled may be, farthest first."""
    far = {name: (0.0, 0.0) for name in step.forces} | dict(step.disturbed)
    much = [
        name
        for name, (moved, turned) in far.items()
        if moved > DISTURBED or turned > TURNED or step.forces.get(name, 0.0) > HIT
    ]
    return sorted(much, key=lambda name: -far[name][0])


def _deed(step: StepRecord) -> str:
    return f"{step.action} {step.object}" if step.object else step.action


def _turns(title: str) -> str:
    return (
        f'<div class="turns"><h2>{escape(title)}</h2><button type="button" data-turn="-1">previous</button>'
        '<button type="button" data-turn="1">next</button></div>'
    )


def _head(record: RunRecord) -> str:
    kind = "good" if record.success else "bad"
    count = len(record.violations)
    facts = [
        f"{len(record.steps)} step{'' if len(record.steps) == 1 else 's'}",
        "no violation" if not count else f"{count} violation{'' if count == 1 else 's'}",
        f"robot {record.robot}",
        f"seed {record.seed}",
    ]
    facts += [f"{record.seconds:.1f} s"] if record.seconds > 0 else []
    return (
        f'<header><h1>{escape(record.goal)}: <span class="{kind}">{record.verdict}</span></h1>'
        f'<p class="lead">{escape(", ".join(facts))}. The arrow keys go from step to step.</p></header>'
    )


def _timeline(record: RunRecord) -> str:
    marks = [
        (
            f"{number}. {step.object or step.action}",
            step.action,
            step.success and not _disturbed_by(step),
        )
        for number, step in enumerate(record.steps, start=1)
    ]
    marks.append(("End", record.verdict, record.success))
    items = "".join(
        f'<li><button type="button" class="{"ok" if ok else "failed"}"><b>{escape(name)}</b>'
        f"<span>{escape(deed)}</span></button></li>"
        for name, deed, ok in marks
    )
    return f'<nav aria-label="steps"><ol class="timeline">{items}</ol></nav>'


def _facts(step: StepRecord) -> str:
    facts = [
        ("result", '<b class="good">done</b>' if step.success else '<b class="bad">failed</b>'),
        ("attempts", str(step.attempts)),
        ("took", f"{step.seconds:.1f} s"),
    ]
    if step.robot_seconds is not None:
        facts.append(("the arm moved for", f"{step.robot_seconds:.1f} s (simulated)"))
    if step.slip is not None:
        facts.append(("slip in the hand", f"{millimetres(step.slip[0])}, {math.degrees(step.slip[1]):.1f}°"))
    return (
        '<div class="facts">'
        + "".join(f"<div><span>{name}</span>{value}</div>" for name, value in facts)
        + "</div>"
    )


def _disturbed(step: StepRecord) -> str:
    """What moved or was hit and was not meant to, farthest first."""
    if not (names := _disturbed_by(step)):
        far, turn = (max((each[k] for each in step.disturbed.values()), default=0.0) for k in (0, 1))
        told = f"{millimetres(far)} and {math.degrees(turn):.1f}°"
        return f"<h2>Disturbed</h2><p>Nothing: the others moved by {told} at most.</p>"
    rows = ""
    for name in names:
        moved, turned = step.disturbed.get(name, (0.0, 0.0))
        force = f"{step.forces[name]:.1f} N" if name in step.forces else ""
        rows += (
            f'<tr class="bad"><td>{escape(name)}</td><td class=number>{millimetres(moved)}</td>'
            f"<td class=number>{math.degrees(turned):.1f}°</td><td class=number>{force}</td></tr>"
        )
    measured = ("moved", "turned", "force")
    return "<h2>Disturbed</h2>" + table(("object", *measured), rows, numbers=measured)


def _predictions(step: StepRecord) -> str:
    """Where what was seen afterwards differs from what was predicted."""
    html = "<h2>Predicted and observed relations</h2>"
    if step.predicted is None or step.observed is None:
        return html + (
            "<p>As predicted.</p>" if step.relations_as_predicted else '<p class="bad">Not as predicted.</p>'
        )
    changes = relation_changes(step.predicted, step.observed)
    against = [change for change in changes if change.counts]
    within = [change for change in changes if not change.counts]
    if step.relations_as_predicted and not against:
        count = len(list(step.observed.get("relations", ())))
        html += f"<p>As predicted: none of the {count} pairs contradicts the prediction.</p>"
    else:
        html += '<p class="bad">Not as predicted.</p>' + _change_table(against)
    if within:
        html += (
            f"<details><summary>{len(within)} difference{'' if len(within) == 1 else 's'} that noise explains"
            "</summary><p class=note>"
            "Another kind of contact, or a pair of which too little was seen to tell contact from a gap; "
            "neither counts.</p>"
            f"{_change_table(within)}</details>"
        )
    return html


def _change_table(changes: Sequence[Change]) -> str:
    if not changes:
        return ""
    rows = "".join(
        f"<tr><td>{escape(c.a)}</td><td>{escape(c.b)}</td><td>{escape(c.predicted)}</td><td>{escape(c.observed)}</td></tr>"
        for c in changes
    )
    return table(("A", "B", "predicted", "observed"), rows)
