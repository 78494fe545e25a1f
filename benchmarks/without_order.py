"""What goes wrong without an order: the same pile, arm and grasps, by plain 6IM + height and by topple.

    python benchmarks/without_order.py [SEED] [OUT.png]

Draws the pile, the first action of the rule of thumb that disturbed something, and how topple left it.
"""

import sys
from textwrap import fill

import numpy as np
from PIL import Image, ImageDraw

from topple.benchmarks.rules import order_by
from topple.planner.execution.demo import loop_in
from topple.planner.execution.judge import LIMITS
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.planning.order import cautious
from topple.robots.scenarios import scenario_called
from topple.robots.world.camera import Camera

RULE = "plain 6IM + height"
EYE = Camera.looking_at((0.47, -0.43, 0.42), (0.0, 0.0, 0.03), width=440, height=330)


def played(seed: int, rule: str | None) -> tuple[RunRecord, list[np.ndarray], str]:
    """Play a pile; a picture before and after each action, and what was wanted."""
    pictures: list[np.ndarray] = []
    with scenario_called("pile", seed) as stage:
        orderer = cautious if rule is None else order_by(rule, stage.pose_base_to_world)
        loop = loop_in(stage, orderer=orderer, seed=seed)
        loop.progress = lambda line: pictures.append(EYE.picture(stage.world))
        return loop.run(), pictures, stage.goal


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
    shown = next((k for k, step in enumerate(theirs.steps) if moved(step)), len(theirs.steps) - 1)
    wrong = theirs.steps[shown]
    words = [
        f"{goal}: where to begin?",
        f"{RULE}: takes {wrong.object}: {moved(wrong) or 'nothing moves'}",
        f"topple: takes {', '.join(step.object for step in ours.steps)}: "
        + ("; ".join(filter(None, map(moved, ours.steps))) or "nothing else moves"),
    ]
    sheet = Image.new("RGB", (3 * EYE.width, EYE.height + 40), "white")
    pictures = [seen[0], seen[2 * shown + 1], calm[-1]]
    for place, (picture, line) in enumerate(zip(pictures, words, strict=True)):
        sheet.paste(Image.fromarray(picture), (place * EYE.width, 0))
        ImageDraw.Draw(sheet).text((place * EYE.width + 8, EYE.height + 5), fill(line, 70), fill="black")
    sheet.quantize(128).save(path)
    print(*words, path, sep="\n")
    return 0 if ours.success else 1


if __name__ == "__main__":
    sys.exit(main(int((sys.argv[1:] or ["4"])[0]), (sys.argv[2:] or ["without_order.png"])[0]))
