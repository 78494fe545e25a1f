"""A stack of dishes turned into a laid table: in which order to build it up, and the fewest moves there."""

import numpy as np

import topple
from topple.robots import shapes

DISHES = {
    "plate": shapes.plate("plate", diameter=0.22),
    "bowl": shapes.bowl("bowl", diameter=0.14),
    "cup": shapes.cup("cup", diameter=0.07),
    "spoon": shapes.spoon("spoon", length=0.17),
}
STACK = {"bowl": (0, 0, 0), "plate": (0, 0, 0.06), "cup": (0.25, 0, 0), "spoon": (0, 0.25, 0)}
LAID = {"plate": (0.25, 0, 0), "bowl": (0.25, 0, 0.008), "cup": (0, 0, 0), "spoon": (0.25, 0.16, 0)}


def scene(places: dict[str, tuple[float, ...]]) -> topple.Scene:
    """The dishes at some places [m], seen from all around, on a table."""
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(np.arange(-0.4, 0.6, 0.01), np.arange(-0.4, 0.4, 0.01)), axis=-1)
    clouds = {"table": np.column_stack([grid.reshape(-1, 2), np.zeros(grid.shape[0] * grid.shape[1])])}
    clouds |= {name: DISHES[name].surface(4000, rng) + np.array(place) for name, place in places.items()}
    return topple.Scene(clouds, fixed=["table"], up=[0, 0, 1])


def main() -> None:
    """Print both orders with their reasons."""
    start, goal = scene(STACK), scene(LAID)
    print("to build the laid table:", *topple.build_order(goal).explanation, sep="\n")
    found = topple.rearrange(start, goal)
    print("from the stack to the laid table:", *found.explanation, sep="\n")
    print(f"{len(found.moves)} moves; no sequence has fewer than {found.bound}")


if __name__ == "__main__":
    main()
