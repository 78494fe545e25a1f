"""Relations of a tracked scene at video rate: of each frame only what changed is related again.

    python examples/10_track.py                  # a spoon goes into a bowl and out again
    python examples/10_track.py recording/       # a folder with a scene file per frame, in the order of names
    python examples/10_track.py recording.npz    # all frames of each object in one array, see `load_sequence`

Prints how many frames it takes in a second, and from which to which frame each relation held.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from topple.planner import show_page
from topple.robots import shapes
from topple.topology import Relation, Scene, load_sequence, relate


def made_up() -> Iterator[Scene]:
    """A spoon comes down into a bowl and leaves it again, both seen all around."""
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.4, 0.4, 81)] * 2, [0.0]), axis=-1).reshape(-1, 3)
    bowl, spoon = shapes.bowl().surface(4000, rng), shapes.spoon().surface(1500, rng)
    scene = Scene({"table": grid, "bowl": bowl, "spoon": spoon}, fixed=["table"], up=[0, 0, 1])
    for turn in np.linspace(0, 2 * np.pi, 60):
        yield scene.with_cloud("spoon", spoon + np.array([0.0, 0.0, 0.13 + 0.1 * np.cos(turn)]))


def main(frames: Iterator[Scene]) -> None:
    """Relate the first frame, follow the others, print the intervals."""
    relations, held, seconds, number = None, {}, 0.0, 0
    for number, scene in enumerate(frames, start=1):
        begun = time.perf_counter()
        same = relations is not None and relations.objects == scene.names  # nothing came or went
        relations = relations.followed(scene) if same else relate(scene)
        seconds += time.perf_counter() - begun
        for pair in relations.pairs:
            if pair.relation is not Relation.DISJOINT:
                spans = held.setdefault(f"{pair.a} {pair.relation} {pair.b}", [])
                if not spans or spans[-1][1] < number - 1:
                    spans.append([number, number])
                spans[-1][1] = number
    if relations is not None:
        Path("track.html").write_text(show_page(relations.scene, relations), encoding="utf-8")
    print(f"{number} frames, {number / seconds:.1f} in a second")
    for relation, spans in held.items():
        print(f"{relation}: frames {', '.join(f'{a}-{b}' if a < b else str(a) for a, b in spans)}")


if __name__ == "__main__":
    main(load_sequence(sys.argv[1]) if len(sys.argv) > 1 else made_up())
