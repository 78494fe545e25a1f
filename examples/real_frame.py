"""From a real RGB-D frame to an arm in simulation: bodies from the clouds, an order, a run, a report.

    python examples/real_frame.py FRAME.npz TABLE [TARGET]

FRAME holds depth (H, W) in metres, K (3, 3) and a mask `label` (H, W); TABLE is the table's label. Without a
TARGET the object is freed that most others have to go before.
"""

import sys
from collections import Counter

from topple.planner import order, run
from topple.planner.report.run_page import run_page
from topple.topology import load_scene


def main(path: str, table: str, target: str | None = None) -> int:
    """Decide from the frame what goes first, then act it out in a world made of what the frame shows."""
    scene = load_scene(path, fixed=[table])
    found = order(scene)
    print(*found.explanation, sep="\n")
    waiting = Counter(edge.then for edge in found.graph.dependencies)
    wanted = target or next((name for name, _ in waiting.most_common(1)), found.order[0])
    record = run(scene, [wanted], "panda-suction", progress=print)  # boxes wider than a hand opens
    for note in record.notes:
        print(f"note: {note}")
    with open("real_frame.html", "w", encoding="utf-8") as page:
        page.write(run_page(record))
    moved = max((way for step in record.steps for way, _ in step.disturbed.values()), default=0.0)
    print(
        f"{record.goal}: {'reached' if record.success else 'not reached'}; others moved {1e3 * moved:.0f} mm"
    )
    print("real_frame.html: every step, to be turned in a browser")
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
