"""The moving picture of the README: what the camera saw, why in this order, and the arm that does it.

    python docs/figures/film.py [docs/dishes.webp]

Needs Chromium (extra `docs`). Leaves with exit code 1, and writes nothing, where the run fails.
"""

import io
import shutil
import sys
from base64 import b64encode
from dataclasses import replace
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from topple.planner.decide.words import because, said
from topple.planner.execution.demo import loop_in
from topple.planner.formats.pictures import jpeg
from topple.planner.formats.run_record import RunRecord
from topple.planner.report.drawing import Drawing
from topple.planner.report.graph import DrawnGraph, graph_box
from topple.planner.report.html import page
from topple.planner.report.photo import photo
from topple.robots import scenario
from topple.robots.world.camera import Camera
from topple.robots.world.photo import photograph
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

EVERY = 1.1  # [s] of simulated time between two pictures of the arm
WAITS = (370, 66, 1300)  # [ms] that a picture stands: as an arrow is drawn, as the arm moves, at the end
EYE, TARGET = (0.82, -0.88, 0.85), (-0.17, 0.0, 0.26)  # [m] the whole arm is in view
SIZE = (1080, 346)  # [pixels]
STYLE = """<style>body { margin: 0; padding: 8px; max-width: none; }
.film { display: grid; gap: 12px; grid-template-columns: 370px 320px 350px; height: 290px;
  align-items: center; }
.film figcaption, .legend { display: none; } .film img { width: 100%; display: block; }
.film .photo, .graph-box { margin: 0; border: 0; background: none; padding: 0; overflow: hidden; }
.film .graph { width: 100%; height: auto; }
.graph text { font-size: 15px; } .graph text.reason { font-size: 14px; }
#said { font-size: 20px; padding: 8px 4px; } .arrow, text.reason { visibility: hidden; }
.drawn { visibility: visible !important; } .gone { opacity: 0.25; }</style>"""
MOMENT = """([drawn, gone, said, picture]) => {
  const each = (which, name, list, key) => document.querySelectorAll(which).forEach(
    (e) => e.classList.toggle(name, list.includes(e.dataset[key])));
  each(".arrow, text.reason", "drawn", drawn, "ends");
  each(".chip, .node", "gone", gone, "object");
  document.getElementById("said").textContent = said;
  document.getElementById("arm").src = picture;
  return document.getElementById("arm").decode();
}"""


def played() -> tuple[RunRecord, list[tuple[int, bytes]]]:
    """Play the dishes; a picture of the arm every so often, with the number of steps done by then."""
    camera = Camera.looking_at(EYE, TARGET, width=800, height=600)
    pictures: list[tuple[int, bytes]] = []
    done = [0]
    with scenario("dishes", 0) as stage:
        loop = loop_in(stage, progress=print)
        begun = stage.world.time

        def look() -> None:
            if stage.world.time >= begun + len(pictures) * EVERY:
                count = sum(arrived(stage.world.pose(name), start[name]) for name in stage.world.movable)
                done[0] = max(done[0], count)
                pictures.append((done[0], seen(stage.world, camera)))

        start = stage.world.poses()
        loop.robot.on_step.append(look)
        record = loop.run()
        pictures.append((len(record.steps), seen(stage.world, camera)))
    return record, pictures


def seen(world: PhysicalWorld, camera: Camera) -> bytes:
    """A photo, its floor of blue and white squares as white as the paper."""
    rgb = photograph(world, camera, whole=True).rgb.copy()
    rgb[(rgb[..., 2] > 120) & (rgb[..., 2] > rgb[..., 0] + 20.0)] = 255
    return jpeg(rgb)


def arrived(now: FloatArray, then: FloatArray) -> bool:
    """Whether an object has left its place by 15 cm."""
    return bool(((now[:3, 3] - then[:3, 3]) ** 2).sum() > 0.15**2)


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
    record, pictures = played()
    if not record.success:
        print(*record.violations, sep="\n")
        return 1
    first, names = record.steps[0], [step.object for step in record.steps]
    assert first.scene is not None and first.order is not None
    order, drawing = {**first.order, "order": names}, Drawing.of(first.scene)
    graph = sideways(DrawnGraph.of(first.scene.movable, order))
    sides = photo(first.scene, drawing, order), graph_box(graph, drawing.colours, drawing.index)
    body = f'{STYLE}<div class="film">{sides[0]}{sides[1]}<img id="arm" alt=""></div><div id="said"></div>'
    ties = sorted(order["dependencies"], key=lambda tie: names.index(tie["first"]))
    number = {name: str(drawing.index[name]) for name in names}
    arrows = [f"{number[tie['first']]} {number[tie['then']]}" for tie in ties]
    still = pictures[0][1]
    moments = [([], [], "To free the plate: what has to go first?", still, WAITS[2] // 2)]
    for count, tie in enumerate(ties, start=1):
        why = (
            f"{because([tie['first']], said(tie), tie['then'])}, so {tie['first']} goes before {tie['then']}."
        )
        moments.append((arrows[:count], [], why, still, WAITS[0]))
    told = [f"Step {i} of {len(names)}: {name}" for i, name in enumerate(names, start=1)]
    for done, picture in pictures:
        gone = [number[name] for name in names[:done]]
        moments.append((arrows, gone, told[min(done, len(told) - 1)], picture, WAITS[1]))
    moments[-1] = (*moments[-1][:2], record.summary, moments[-1][3], WAITS[2])
    frames: list[Image.Image] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        tab.set_content(page("film", body, {}, ()))
        for drawn, gone, text, picture, _ in moments:
            data = f"data:image/jpeg;base64,{b64encode(picture).decode()}"
            tab.evaluate(MOMENT, [drawn, gone, text, data])
            frames.append(Image.open(io.BytesIO(tab.screenshot())).convert("RGB"))
        browser.close()
    begin, *others = frames
    waits = [wait for *_, wait in moments]
    begin.save(target, save_all=True, append_images=others, duration=waits, loop=0, quality=72, method=6)
    size = Path(target).stat().st_size / 1e6
    print(f"{target}: {len(frames)} pictures, {sum(waits) / 1000:.1f} s, {size:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
