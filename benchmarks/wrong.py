"""Pictures of pairs that reasoning still gets wrong: `python -m topple.benchmarks.wrong -o docs/wrong`.

Each shows what the lift oracle does in a seeded pile seen whole: the pile before, as the one that is asked
about moves (or the lifted one passes), and after. What is lifted is orange, what is asked about blue. A pair
that is right by now is refused; `--search FROM TO` prints the wrong ones of other piles.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from topple.benchmarks.piles import Pile, make_pile, observe
from topple.planner.cli.console import print_json
from topple.planner.decide.dependency import dependencies
from topple.planner.simulate.lift import Move
from topple.planner.simulate.lifts import set_friction, take_away
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput

LIFTED = (0.95, 0.5, 0.1, 1.0)
ASKED = (0.15, 0.4, 0.85, 1.0)
OTHERS = (0.78, 0.78, 0.76, 1.0)

MOVING = 0.005
"""Displacement [m] at which the second picture is taken: half a move."""

MOVED, TURNED = 0.01, 10.0
"""Displacement [m] and turn [degrees] that count as a move."""

PASSING = 0.04
"""Height [m] of the lift at which it is taken where nothing moves."""

SIZE, FINE = (360, 300), 2
"""Of one picture [px], and how many times larger it is taken: smooth edges."""

COLOURS = 96
"""Of a picture's palette: small files."""


@dataclass(frozen=True)
class Example:
    """A pair that is wrong.

    Attributes:
        kind: What the reasoning misses.
        seed: Of the pile.
        first: What is asked about.
        then: What is lifted.
        eye: (x, y, z) from where it shows, from the middle of the two [m].
    """

    kind: str
    seed: int
    first: str
    then: str
    eye: tuple[float, float, float] = (0.3, -0.35, 0.22)


EXAMPLES = (
    Example("drag", 7_400_022, "bowl_1", "plate_2"),
    Example("roll", 7_400_004, "ball_2", "box_1", (0.0, -0.45, 0.3)),
    Example("tilt", 7_400_027, "flat_3", "can_5", (-0.35, -0.3, 0.22)),
    Example("counterweight", 7_400_054, "tray_4", "lemon_6"),
    Example("hook", 7_400_007, "can_4", "spoon_0"),
)
"""One of each kind."""


def shown(example: Example, folder: Path) -> dict[str, object]:
    """Draw an example and say what is wrong about it.

    Args:
        example: The pair.
        folder: Where `KIND.png` goes.

    Returns:
        The kind, what reasoning says of the pair, and how far the object moves.

    Raises:
        InvalidInput: The pair is right: what reasoning says of it is what happens.
    """
    pile = make_pile(example.seed)
    graph = dependencies(observe(pile, 0, example.seed))
    pictures, move = _lift(pile, example)
    said = example.first in graph.before(example.then)
    if said == move.beyond(MOVED, TURNED):
        raise InvalidInput(
            f"{example}: this pair is right by now, so it is no example: --search finds others"
        )
    folder.mkdir(parents=True, exist_ok=True)
    _save(pictures, folder / f"{example.kind}.png")
    return {"kind": example.kind, **_told(example.seed, example.first, example.then, said, move)}


def searched(seed: int) -> Iterator[dict[str, object]]:
    """Every pair of a pile that is wrong.

    Args:
        seed: Of the pile.

    Yields:
        Pile, pair, what reasoning says of it, and how far the object moves.
    """
    pile = make_pile(seed)
    graph = dependencies(observe(pile, 0, seed))
    with pile.world() as world:
        set_friction(world, 0.5, 0.6)
        for then in pile.poses:
            for first, move in take_away(world, then).items():
                said = first in graph.before(then)
                if said != move.beyond(MOVED, TURNED):
                    yield _told(seed, first, then, said, move)


def _told(seed: int, first: str, then: str, said: bool, move: Move) -> dict[str, object]:
    moved = [round(move.distance, 4), round(float(np.degrees(move.angle)), 1)]
    return {"pile": seed, "first": first, "then": then, "said": said, "moved": moved}


def _lift(pile: Pile, example: Example) -> tuple[list[NDArray[np.uint8]], Move]:
    """Three pictures of a lift, and how far the one asked about gets."""
    paint = {example.first: ASKED, example.then: LIFTED}
    bodies = tuple(body.colored(paint.get(body.name, OTHERS)) for body in pile.bodies)
    with Pile(bodies, pile.poses).world() as world:
        set_friction(world, 0.5, 0.6)
        middle = (pile.poses[example.first][:3, 3] + pile.poses[example.then][:3, 3]) / 2
        eye = middle + np.asarray(example.eye)
        x, y, z = middle
        camera = Camera.looking_at(
            (float(eye[0]), float(eye[1]), float(eye[2])), (float(x), float(y), float(z)),
            width=SIZE[0] * FINE, height=SIZE[1] * FINE, fov=np.radians(50),
        )  # fmt: skip
        pictures = [camera.picture(world)]
        moves = take_away(world, example.then, watch=_photographer(world, example, camera, pictures))
    return pictures[:2] + pictures[-1:], moves[example.first]


def _photographer(
    world: World, example: Example, camera: Camera, pictures: list[NDArray[np.uint8]]
) -> Callable[[World], None]:
    """Takes a picture once the scene moves, and once the lifted one is gone."""
    start, from_height = world.pose(example.first)[:3, 3], world.pose(example.then)[2, 3]

    def watch(world: World) -> None:
        risen = world.pose(example.then)[2, 3] - from_height
        moved = float(np.linalg.norm(world.pose(example.first)[:3, 3] - start))
        if len(pictures) == 1 and (moved > MOVING or risen > PASSING):
            pictures.append(camera.picture(world))
        if risen > 10.0:  # taken out of the world: all is over
            pictures.append(camera.picture(world))

    return watch


def _save(pictures: list[NDArray[np.uint8]], path: Path) -> None:
    """Pictures side by side as a PNG."""
    from PIL import Image  # nothing else here draws

    image = Image.fromarray(np.concatenate(pictures, axis=1))
    image = image.resize((image.width // FINE, image.height // FINE), Image.Resampling.LANCZOS)
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> None:
    """Draw all examples and print what is wrong about each as JSON."""
    parser = argparse.ArgumentParser(description="Draw pairs that reasoning still gets wrong.")
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/wrong"), help="folder of the pictures")
    parser.add_argument(
        "--search", type=int, nargs=2, metavar=("FROM", "TO"), help="wrong pairs of these piles"
    )
    args = parser.parse_args()
    if args.search:
        for seed in range(*args.search):
            for pair in searched(seed):
                print_json(pair)
        return
    print_json({"wrong": [shown(example, args.out) for example in EXAMPLES]})


if __name__ == "__main__":
    main()
