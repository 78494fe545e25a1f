"""From an RGB-D frame to an arm in simulation: bodies from the clouds, an order, a run, a report.

    python examples/05_real_frame.py                          # a frame of a simulated camera
    python examples/05_real_frame.py FRAME.npz TABLE [TARGET]

FRAME holds depth (H, W) in metres, K (3, 3) and a mask `label` (H, W); TABLE is the table's label. Without a
TARGET the object is freed that most others have to go before.
"""

import sys
from collections import Counter

import numpy as np

from topple.planner import order, run, run_page
from topple.robots import scenario
from topple.topology import load_scene


def simulated(path: str = "frame.npz") -> tuple[str, str]:
    """Write what one depth camera sees of a built-in scene as a driver would; returns path and table."""
    with scenario("tower", 0) as stage:
        image = stage.cameras[0].look(stage.world, np.random.default_rng(0))
        table = next(label for label, name in image.names.items() if name in stage.fixed)
    np.savez_compressed(
        path, depth=image.depth.astype(np.float32), K=image.K, label=image.label.astype(np.uint8)
    )
    return path, str(table)


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
    print(f"{record.goal}: {record.verdict}; real_frame.html shows every step")
    return 0 if record.success else 1


if __name__ == "__main__":
    if len(sys.argv) == 2:
        sys.exit(f"{sys.argv[0]}: which label is the table? expected FRAME.npz TABLE [TARGET]")
    sys.exit(main(*(sys.argv[1:] or simulated())))
