"""The page of a closed-loop run: a timeline, and for each step what was seen, done and disturbed."""

import math
from collections.abc import Sequence
from html import escape
from typing import Any

from topple.planner.decide.names import photo_of, spoken
from topple.planner.decide.words import millimetres, number_of, sentence
from topple.planner.formats.pictures import picture, pixels_of
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.report.drawing import Drawing, view_data
from topple.planner.report.html import bullets, fold, glance, page, plain_table, table, viewer
from topple.planner.report.limits import LIMITS
from topple.planner.report.photo import Box, around, cut, jpeg_url, masks, photo_figure, said_of_masks
from topple.planner.report.played import arm_shape, motion_json
from topple.planner.report.show import dependency_section, with_look
from topple.planner.report.tables import order_list, relation_changes, relation_table
from topple.planner.tolerances import DISTURBED, HIT, TURNED
from topple.topology.base.arguments import checked_arguments
from topple.topology.views.image import Photo

Look = tuple[bytes | None, str]  # a picture as a file, and when it was taken


@checked_arguments
def run_page(
    record: RunRecord, *, points: int = LIMITS.run_points, photos: bool = True, compact: bool = False
) -> str:
    """Draw a run as one self-contained HTML page, whose steps the timeline, buttons or arrow keys turn.

    Args:
        record: The run. Whatever a step lacks (pictures, scene, order) is left out of the page.
        points: Points that may be drawn in all.
        photos: Whether what the cameras saw is shown.
        compact: Without margins, for a notebook's cell.

    Examples:
        >>> "Plate freed" in run_page(RunRecord("free plate", "panda", 0, success=True))
        True
    """
    first = next((step.scene for step in record.steps if step.scene is not None), None)
    record = record if first is None else spoken(first, record)
    return _RunPage(record, points, photos).build(compact)


class _RunPage:
    """Collects pictures and views while the steps are written; each picture is embedded once."""

    def __init__(self, record: RunRecord, points: int, photos: bool) -> None:
        self.record, self.photos = record, photos
        self.pictures: dict[tuple[bytes, Box], int] = {}
        self.views: list[dict[str, Any]] = []
        scenes = sum(step.scene is not None for step in record.steps) + (record.scene is not None)
        self.arm = arm_shape(record.arm)
        self.points = min(LIMITS.page_points, points // max(scenes, 1))
        shown = [_photo_of(step) for step in record.steps]
        fixed = frozenset[str]().union(*(step.scene.fixed for step in record.steps if step.scene is not None))
        self.box = around([one for one in shown if one is not None], fixed)  # one for all: they compare

    def build(self, compact: bool) -> str:
        record = self.record
        sections = [self.step(number, step) for number, step in enumerate(record.steps, start=1)]
        body = _head(record) + _timeline(record) + f"<main>{''.join(sections)}{self.end()}</main>"
        pictures = [jpeg_url(cut(pixels_of(data), box)) for data, box in self.pictures]
        data = {"views": self.views, "pictures": pictures, "arm": self.arm}
        scripts = ["light.js", "viewer.js", "motion.js", "page.js", "run.js"]
        return page(f"topple: {record.goal}", body, data, scripts, compact=compact)

    def step(self, number: int, step: StepRecord) -> str:
        deed = f"{step.action} {step.object}" if step.object else step.action
        html = _turns(f"Step {number} of {len(self.record.steps)}: {deed}")
        html += f"<p>{escape(sentence(step.reason))}</p>" if step.reason else ""
        html += bullets([sentence(text) for text in step.events])
        drawing = None if step.scene is None else Drawing.of(step.scene, self.points, step.photo)
        words, graph = self.order_html(drawing, step)
        done = _facts(step) + _disturbance_words(step) + _predictions(step)
        html += glance(self.photos_of(step, drawing), words, graph + done)
        html += self.view_html(drawing, step, "Seen before this step, and what the arm did")
        return f'<section class="step">{html}</section>'

    def end(self) -> str:
        record = self.record
        html = _turns(f"End: the goal is {record.verdict}")
        if record.violations:
            html += '<h2 class="bad">Violations</h2>' + bullets(record.violations)
        html += "<h2>Notes</h2>" + bullets(record.notes) if record.notes else ""
        drawing = None if record.scene is None else Drawing.of(record.scene, self.points)
        last = record.steps[-1].picture_after if record.steps else None
        looks = (last, "at the end"), (record.wanted, "as wanted")
        html += glance(self.compare(around((), ()), looks), *self.order_html(drawing, record))
        html += self.view_html(drawing, record, "Seen at the end")
        return f'<section class="step">{html}</section>'

    def photos_of(self, step: StepRecord, drawing: Drawing | None) -> str:
        """Pictures of a camera before, masks outlined, and after."""
        shown, before, marks, words = _photo_of(step), step.picture_before, "", ""
        if drawing is not None and step.scene is not None and shown is not None:
            marks = masks(shown, self.box, step.scene, drawing, step.order)
            words = said_of_masks(step.scene, step.order)
            before = before or picture(shown.rgb)
        return self.compare(self.box, ((before, "before"), (step.picture_after, "after")), marks, words)

    def compare(self, box: Box, looks: Sequence[Look], marks: str = "", words: str = "") -> str:
        """The same part of two pictures of one camera, one over the other, and a slider between them."""
        shown = [(data, word) for data, word in looks if data and self.photos]
        images = []
        for place, (data, word) in enumerate(shown):
            number = self.pictures.setdefault((data, box), len(self.pictures))  # one may serve two steps
            kind = ' class="over after"' if place else ""
            images.append(f'<img{kind} data-picture="{number}" alt="camera, {word}">')
        if not images:
            return ""
        slider = (
            f'<label class="cut"><span>{looks[0][1]}</span><input type="range" min="0" max="100" value="0" '
            f'autocomplete="off" aria-label="how much is {looks[1][1]}"><span>{looks[1][1]}</span></label>'
        )
        return photo_figure(images[0], marks + "".join(images[1:]), words, slider if len(images) > 1 else "")

    def order_html(self, drawing: Drawing | None, moment: StepRecord | RunRecord) -> tuple[str, str]:
        """The order from a moment on, and its graph."""
        if moment.scene is None or drawing is None or moment.order is None:
            return "", ""
        words = "<h2>Order from here</h2>" + order_list(with_look(moment.scene, moment.order), drawing.index)
        return words, dependency_section(moment.scene, drawing, moment.order)

    def view_html(self, drawing: Drawing | None, moment: StepRecord | RunRecord, title: str) -> str:
        """View and relations of one moment."""
        relations, order = moment.relations, moment.order
        if drawing is None:
            return ""
        path = moment.tool_path if isinstance(moment, StepRecord) else None
        motion = moment.motion if self.record.arm and isinstance(moment, StepRecord) else None
        told = None if motion is None else motion_json(motion, self.arm, drawing.index, drawing.centre)
        self.views.append(view_data(drawing, relations or {}, order, path, told))
        html = f"<h2>{escape(title)}</h2>{viewer(len(self.views) - 1, self.views[-1])}"
        told = "" if relations is None else fold("Relations", relation_table(relations, drawing.index))
        return html + told


def _photo_of(step: StepRecord) -> Photo | None:
    """The photo of a step, with its masks."""
    return step.photo or (None if step.scene is None else photo_of(step.scene))


def _disturbed_by(step: StepRecord) -> list[str]:
    """Objects that moved, turned or were hit more than those not handled may be, farthest first."""
    far = {name: (0.0, 0.0) for name in step.forces} | dict(step.disturbed)
    much = [
        name
        for name, (moved, turned) in far.items()
        if moved > DISTURBED or turned > TURNED or step.impulses.get(name, 0.0) > HIT
    ]
    return sorted(much, key=lambda name: -far[name][0])


def _turns(title: str) -> str:
    return (
        f'<div class="turns"><h2>{escape(title)}</h2><button type="button" data-turn="-1">previous</button>'
        '<button type="button" data-turn="1">next</button></div>'
    )


def _head(record: RunRecord) -> str:
    facts = [
        f"{record.goal}: {number_of(len(record.steps), 'step')}",
        f"robot {record.robot}, seed {record.seed}",
        *([f"{record.seconds:.1f} s"] if record.seconds > 0 else []),
    ]
    return (
        f'<header><h1 class="{"good" if record.success else "bad"}">{escape(record.summary)}</h1>'
        f'<p class="lead">{escape(", ".join(facts))}. The arrow keys go from step to step.</p></header>'
    )


def _timeline(record: RunRecord) -> str:
    marks = [
        (f"{number}. {step.object or step.action}", step.action, step.success and not _disturbed_by(step))
        for number, step in enumerate(record.steps, start=1)
    ]
    items = "".join(
        f'<li><button type="button" class="{"ok" if ok else "failed"}"><b>{escape(name)}</b>'
        f"<span>{escape(deed)}</span></button></li>"
        for name, deed, ok in [*marks, ("End", record.verdict, record.success)]
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
        facts.append(("slip in the hand", _shift(*step.slip, ", ")))
    return (
        f'<div class="facts">{"".join(f"<div><span>{name}</span>{fact}</div>" for name, fact in facts)}</div>'
    )


def _shift(far: float, turn: float, between: str) -> str:
    return f"{millimetres(far)}{between}{math.degrees(turn):.1f}°"


def _disturbance_words(step: StepRecord) -> str:
    """Tabulate the objects that moved or were hit and were not meant to, farthest first."""
    if not (names := _disturbed_by(step)):
        far, turn = (max((each[k] for each in step.disturbed.values()), default=0.0) for k in (0, 1))
        return f"<h2>Disturbed</h2><p>Nothing: the others moved by {_shift(far, turn, ' and ')} at most.</p>"
    fell = {name: f"{millimetres(drop)}, {energy:.2f} J" for name, (drop, energy) in step.severity.items()}
    rows = "".join(
        f'<tr class="bad"><td>{escape(name)}</td><td class=number>'
        f"{_shift(*step.disturbed.get(name, (0.0, 0.0)), '</td><td class=number>')}</td>"
        f"<td class=number>{f'{step.forces[name]:.1f} N' if name in step.forces else ''}</td>"
        f"<td class=number>{f'{step.impulses[name]:.2f} N s' if name in step.impulses else ''}</td>"
        f"<td class=number>{fell.get(name, '')}</td></tr>"
        for name in names
    )
    measured = ("moved", "turned", "force", "hit", "fell by, with")
    return "<h2>Disturbed</h2>" + table(("object", *measured), rows, numbers=measured)


def _predictions(step: StepRecord) -> str:
    """Where what was seen afterwards contradicts what was predicted."""
    html, against = "<h2>Predicted and observed relations</h2>", list[tuple[str, ...]]()
    if step.predicted is not None and step.observed is not None:
        changes = relation_changes(step.predicted, step.observed)
        against = [change[:4] for change in changes if change.counts]
    if step.relations_as_predicted and not against:
        return f"{html}<p>As predicted.</p>"
    wrong = plain_table(("A", "B", "predicted", "observed"), against) if against else ""
    return f'{html}<p class="bad">Not as predicted.</p>{wrong}'
