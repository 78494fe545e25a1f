"""From plain arrays to relations and a safe order with its reasons: a book on two boxes, a ball on the book.

python examples/order_clouds.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from topple.planner import order, show_page
from topple.topology import Relation, Scene, relate

Points = NDArray[np.float64]  # (N, 3) in [m]
RNG = np.random.default_rng(0)


def box(centre: tuple[float, float, float], size: tuple[float, float, float]) -> Points:
    """Points on the six faces of a box."""
    points = RNG.uniform(-0.5, 0.5, (2000, 3))
    face = RNG.integers(0, 3, len(points))
    points[np.arange(len(points)), face] = RNG.choice([-0.5, 0.5], len(points))
    return np.array(centre) + points * size


def ball(centre: tuple[float, float, float], radius: float) -> Points:
    """Points on a sphere."""
    points = RNG.normal(size=(2000, 3))
    return np.array(centre) + radius * points / np.linalg.norm(points, axis=1, keepdims=True)


def main() -> None:
    """Relate and order the objects of a small scene."""
    scene = Scene(
        {
            "table": box((0.0, 0.0, -0.01), (0.8, 0.6, 0.02)),
            "left": box((-0.08, 0.0, 0.05), (0.06, 0.10, 0.10)),
            "right": box((0.08, 0.0, 0.05), (0.06, 0.10, 0.10)),
            "book": box((0.0, 0.0, 0.11), (0.25, 0.18, 0.02)),
            "ball": ball((0.02, 0.0, 0.15), 0.03),
        },
        fixed=["table"],
        up=[0, 0, 1],
    )
    relations = relate(scene)
    for pair in relations.pairs:
        if pair.relation is not Relation.DISJOINT:
            print(f"{pair.a} - {pair.b}: {pair.relation} (gap {1000 * pair.gap:.1f} mm)")

    found = order(scene, "left", relations=relations)
    print(f"to free the left box: {', '.join(found.order)}")
    print(*found.explanation, sep="\n")
    page = Path("order.html")
    page.write_text(show_page(scene, relations, found), encoding="utf-8")
    print(f"{page}: what is where, and why in this order")


if __name__ == "__main__":
    main()
