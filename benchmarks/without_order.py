"""What goes wrong without an order: the same pile, arm and grasps, by plain 6IM + height and by topple.

    python benchmarks/without_order.py [SEED] [OUT.png]

Draws the pile, the first action of the rule of thumb that disturbed something, and how topple left it. Leaves
with exit code 1, and writes nothing, where the rule disturbs nothing or topple fails: no difference to see.
"""

import re
import sys
from textwrap import fill

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from topple.benchmarks.rules import order_by
from topple.planner.execution.demo import loop_in
from topple.planner.execution.judge import LIMITS
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.planning.order import cautious
from topple.robots import scenario
from topple.robots.scenarios import Scenario
from topple.robots.world.camera import Camera

RULE = "plain 6IM + height"
SIZE, FINE = (440, 330), 2  # of a picture [px], and how many times larger it is taken: smooth edges
EYE = Camera.looking_at((0.47, -0.43, 0.42), (0.0, 0.0, 0.03), width=SIZE[0] * FINE, height=SIZE[1] * FINE)
WORDS = ImageFont.load_default(size=13)
NAMES = ImageFont.load_default(size=13 * FINE)


def named(stage: Scenario) -> Image.Image:
    """The world as it is, with the name of each thing that can be told from the others there."""
    picture = Image.fromarray(EYE.picture(stage.world))
    pen = ImageDraw.Draw(picture)
    to_camera = np.linalg.inv(EYE.pose_camera_to_world)
    taken: list[tuple[float, float, float, float]] = []
    for name in sorted(set(stage.world.ids) - set(stage.fixed), key=lambda name: name not in stage.targets):
        corners = np.vstack(stage.world.parts(name))
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        x, y, depth = EYE.K @ (to_camera @ np.append(middle, 1.0))[:3]
        box = pen.textbbox((x / depth, y / depth), name, font=NAMES, anchor="mm", stroke_width=4)
        apart = all(box[0] > b[2] or box[2] < b[0] or box[1] > b[3] or box[3] < b[1] for b in taken)
        if apart and box[0] >= 0 and box[1] >= 0 and box[2] <= EYE.width and box[3] <= EYE.height:
            taken.append(box)
            pen.text(
                box[:2], name, font=NAMES, fill="black", anchor="la", stroke_width=4, stroke_fill="white"
            )
    return picture


def played(seed: int, rule: str | None) -> tuple[RunRecord, list[Image.Image], str]:
    """Play a pile; a picture before each action and at the end, and what was wanted."""
    pictures: list[Image.Image] = []
    with scenario("pile", seed) as stage:
        orderer = cautious if rule is None else order_by(rule, stage.pose_base_to_world)
        loop = loop_in(stage, orderer=orderer, seed=seed)

        def look(line: str) -> None:
            if re.match(r"\d+ of \d+: ", line):
                pictures.append(named(stage))

        loop.progress = look
        return loop.run(), [*pictures, named(stage)], stage.goal


def moved(step: StepRecord) -> str:
    """What a step moved or tipped though it was not about it."""
    found = [
        f"{name} moves {1e3 * way:.0f} mm, turns {np.degrees(turn):.0f} degrees"
        for name, (way, turn) in step.disturbed.items()
        if way > LIMITS.distance or turn > LIMITS.angle
    ]
    return "; ".join(found)


def main(seed: int, path: str) -> int:
    """Play both, and put three pictures side by side."""
    (theirs, seen, goal), (ours, calm, _) = played(seed, RULE), played(seed, None)
    shown = next((k for k, step in enumerate(theirs.steps) if moved(step)), None)
    if shown is None or not ours.success:
        print(f"pile {seed} shows no difference: {RULE} disturbs nothing in it, or topple fails")
        return 1
    wrong = theirs.steps[shown]
    words = [
        f"{goal}: where to begin?",
        f"{RULE}: takes {wrong.object}: {moved(wrong)}",
        f"topple: takes {', '.join(step.object for step in ours.steps if step.success)}: nothing else moves",
    ]
    sheet = Image.new("RGB", (3 * SIZE[0], SIZE[1] + 60), "white")
    pictures = [seen[0], seen[shown + 1], calm[-1]]
    for place, (picture, line) in enumerate(zip(pictures, words, strict=True)):
        sheet.paste(picture.resize(SIZE, Image.Resampling.LANCZOS), (place * SIZE[0], 0))
        pen = ImageDraw.Draw(sheet)
        pen.text((place * SIZE[0] + 8, SIZE[1] + 4), fill(line, 60), fill="black", font=WORDS)
    sheet.quantize(128).save(path)
    print(*words, path, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(int((sys.argv[1:] or ["21"])[0]), (sys.argv[2:] or ["without_order.png"])[0]))
