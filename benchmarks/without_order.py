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
from topple.robots.scenarios import scenario_called
from topple.robots.world.camera import Camera

RULE = "plain 6IM + height"
SIZE, FINE = (440, 330), 2  # of a picture [px], and how many times larger it is taken: smooth edges
EYE = Camera.looking_at((0.47, -0.43, 0.42), (0.0, 0.0, 0.03), width=SIZE[0] * FINE, height=SIZE[1] * FINE)
WORDS = ImageFont.load_default(size=13)


def played(seed: int, rule: str | None) -> tuple[RunRecord, list[np.ndarray], str]:
    """Play a pile; a picture before each action and at the end, and what was wanted."""
    pictures: list[np.ndarray] = []
    with scenario_called("pile", seed) as stage:
        orderer = cautious if rule is None else order_by(rule, stage.pose_base_to_world)
        loop = loop_in(stage, orderer=orderer, seed=seed)

        def look(line: str) -> None:
            if re.match(r"\d+ of \d+: ", line):
                pictures.append(EYE.picture(stage.world))

        loop.progress = look
        return loop.run(), [*pictures, EYE.picture(stage.world)], stage.goal


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
    sheet = Image.new("RGB", (3 * SIZE[0], SIZE[1] + 44), "white")
    pictures = [seen[0], seen[shown + 1], calm[-1]]
    for place, (picture, line) in enumerate(zip(pictures, words, strict=True)):
        sheet.paste(Image.fromarray(picture).resize(SIZE, Image.Resampling.LANCZOS), (place * SIZE[0], 0))
        pen = ImageDraw.Draw(sheet)
        pen.text((place * SIZE[0] + 8, SIZE[1] + 4), fill(line, 60), fill="black", font=WORDS)
    sheet.quantize(128).save(path)
    print(*words, path, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(int((sys.argv[1:] or ["21"])[0]), (sys.argv[2:] or ["without_order.png"])[0]))
