"""The moving picture of the README: what the camera saw, why in this order, and the arm that does it.

    python docs/figures/film.py [docs/dishes.webp]

Needs Chromium (extra `docs`). Leaves with exit code 1, and writes nothing, where the run fails.
"""

import io
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

from topple.planner.decide.words import because, said
from topple.planner.execution.demo import loop_in
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.report.drawing import Drawing, view_data
from topple.planner.report.graph import DrawnGraph, graph_box
from topple.planner.report.html import page
from topple.planner.report.photo import photo
from topple.planner.report.played import arm_shape, motion_json
from topple.robots import scenario

EVERY = 0.9  # [s] of the arm's motion between two pictures of it
WAITS = (370, 66, 1300)  # [ms] that a picture stands: as an arrow is drawn, as the arm moves, at the end
EYE, TARGET, RADIUS = (1.03, -1.43, 1.05), (-0.08, -0.06, 0.29), 0.7  # [m] the whole arm is in view
SIZE = (1080, 346)  # [pixels]
STYLE = """<style>body { margin: 0; padding: 8px; max-width: none; }
.film { display: grid; gap: 12px; grid-template-columns: 370px 320px 350px; height: 290px;
  align-items: center; }
.film figcaption, .legend { display: none; } .film img { width: 100%; display: block; }
.film .photo, .graph-box { margin: 0; border: 0; background: none; padding: 0; overflow: hidden; }
.film .graph { width: 100%; height: auto; }
.graph text { font-size: 15px; } .graph text.reason { font-size: 14px; }
.film canvas { height: 290px; border: 0; background: var(--paper); } canvas[hidden] { display: none; }
#said { font-size: 20px; padding: 8px 4px; } .arrow, text.reason { visibility: hidden; }
.drawn { visibility: visible !important; } .gone { opacity: 0.25; }</style>"""
BEGIN = """() => {
  const { views, arm } = JSON.parse(document.getElementById("data").textContent);
  window.arms = [...document.querySelectorAll("#arm canvas")].map((canvas, i) => {
    canvas.hidden = false;
    const viewer = new Viewer(canvas, views[i], () => {}), motion = new Motion(views[i].motion, arm);
    Object.assign(viewer.show, { relations: false, names: false, order: false });
    return { canvas, show: (time) => {
      viewer.distance = Math.hypot(...sub(views[i].eye, views[i].centre));
      clearTimeout(viewer.calming);
      viewer.busy = false;
      viewer.pose(motion, time);
      viewer.draw();
    } };
  });
}"""
MOMENT = """([drawn, gone, said, step, time]) => {
  const each = (which, name, list, key) => document.querySelectorAll(which).forEach(
    (e) => e.classList.toggle(name, list.includes(e.dataset[key])));
  each(".arrow, text.reason", "drawn", drawn, "ends");
  each(".chip, .node", "gone", gone, "object");
  document.getElementById("said").textContent = said;
  window.arms.forEach(({ canvas }, i) => { canvas.hidden = i !== step; });
  window.arms[step].show(time);
}"""


def played() -> RunRecord:
    """Play the dishes."""
    with scenario("dishes", 0) as stage:
        return loop_in(stage, progress=print).run()


def acted(step: StepRecord, arm: dict[str, Any]) -> dict[str, Any]:
    """What the page's own viewer shows of a step: the scene as it was seen, and the arm's motion in it."""
    assert step.scene is not None and step.motion is not None
    here = np.array(TARGET)
    drawing = replace(Drawing.of(step.scene, taken=step.photo), centre=here, eye=np.array(EYE), radius=RADIUS)
    return view_data(drawing, {}, None, motion=motion_json(step.motion, arm, drawing.index, here))


def sideways(graph: DrawnGraph) -> DrawnGraph:
    """The graph with its layers from left to right, objects of a layer in the order they are taken."""
    layers = sorted({y for _, y, _ in graph.boxes.values()})
    rows = {
        y: sorted((n for n in graph.boxes if graph.boxes[n][1] == y), key=graph.places.get) for y in layers
    }
    most = max(map(len, rows.values()))
    boxes = {
        name: (75.0 + 230.0 * layers.index(y), 30.0 + 62.0 * (k + (most - len(names)) / 2), 130.0)
        for y, names in rows.items()
        for k, name in enumerate(names)
    }
    routes = {
        (a, b): [(boxes[a][0] + 65, boxes[a][1]), (boxes[b][0] - 65, boxes[b][1])] for a, b in graph.routes
    }
    labels = {edge: ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for edge, (a, b) in routes.items()}
    size = {"width": 85.0 + 230.0 * (len(layers) - 1) + 65, "height": 62.0 * most}
    return replace(graph, boxes=boxes, routes=routes, labels=labels, **size)


def main(target: str = "docs/dishes.webp") -> int:
    """Draw the panels once, then one screenshot for each moment."""
    record = played()
    if not record.success:
        print(*record.violations, sep="\n")
        return 1
    first, names = record.steps[0], [step.object for step in record.steps]
    assert first.scene is not None and first.order is not None
    order, drawing, arm = {**first.order, "order": names}, Drawing.of(first.scene), arm_shape(record.arm)
    views = [acted(step, arm) for step in record.steps]
    graph = sideways(DrawnGraph.of(first.scene.movable, order))
    sides = photo(first.scene, drawing, order), graph_box(graph, drawing.colours, drawing.index)
    arms = f'<div id="arm">{"<canvas hidden></canvas>" * len(views)}</div>'
    body = f'{STYLE}<div class="film">{sides[0]}{sides[1]}{arms}</div><div id="said"></div>'
    ties = sorted(order["dependencies"], key=lambda tie: names.index(tie["first"]))
    number = {name: str(drawing.index[name]) for name in names}
    arrows = [f"{number[tie['first']]} {number[tie['then']]}" for tie in ties]
    moments = [([], [], "To free the plate: what has to go first?", 0, 0.0, WAITS[2] // 2)]
    for count, tie in enumerate(ties, start=1):
        why = f"{because([tie['first']], said(tie), tie['then'])}, so {tie['first']} goes first."
        moments.append((arrows[:count], [], why, 0, 0.0, WAITS[0]))
    for step, (name, view) in enumerate(zip(names, views, strict=True)):
        gone, last = [number[other] for other in names[:step]], view["motion"]["times"][-1]
        told = f"Step {step + 1} of {len(names)}: {name}"
        moments += [(arrows, gone, told, step, time, WAITS[1]) for time in np.arange(0, last, EVERY).tolist()]
    moments.append((arrows, [number[name] for name in names], record.summary, len(views) - 1, last, WAITS[2]))
    frames: list[Image.Image] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--use-angle=swiftshader"]
        )
        tab = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        scripts = ("light.js", "viewer.js", "motion.js")
        tab.set_content(page("film", body, {"views": views, "arm": arm}, scripts))
        tab.evaluate(BEGIN)
        for *moment, _ in moments:
            tab.evaluate(MOMENT, moment)
            frames.append(Image.open(io.BytesIO(tab.screenshot())).convert("RGB"))
        browser.close()
    begin, *others = frames
    waits = [moment[-1] for moment in moments]
    begin.save(target, save_all=True, append_images=others, duration=waits, loop=0, quality=72, method=6)
    size = Path(target).stat().st_size / 1e6
    print(f"{target}: {len(frames)} pictures, {sum(waits) / 1000:.1f} s, {size:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
