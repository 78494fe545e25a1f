"""The paper's fourteen scenes: what is in them, how it is related, and what the paper measured.

Section 4 of the paper names most relations; some it leaves to the eye: what leans on a thing that lies on the
ground touches the ground too. A pair that is not listed is disjoint.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

from topple.topology.base.values import FrozenDict
from topple.topology.sixim.table import Relation

TOUCH, WITHIN, PARTIAL = Relation.TOUCH, Relation.WITHIN, Relation.PARTIAL_WITHIN

Listed = tuple[str, Relation, str]
"""(a, relation, b): "a relation b"."""


@dataclass(frozen=True)
class PaperScene:
    """One scene.

    Attributes:
        number: 1 to 14, as in the paper.
        objects: Names, what everything stands on first.
        listed: The pairs that are not disjoint, each once.
    """

    number: int
    objects: tuple[str, ...]
    listed: tuple[Listed, ...]

    @property
    def ground(self) -> str:
        """Name of what everything stands on."""
        return self.objects[0]

    @property
    def pairs(self) -> tuple[Listed, ...]:
        """Every unordered pair once, disjoint ones too."""
        known = {frozenset((a, b)): (a, relation, b) for a, relation, b in self.listed}
        return tuple(
            known.get(frozenset(pair), (pair[0], Relation.DISJOINT, pair[1]))
            for pair in combinations(self.objects, 2)
        )


def _scene(number: int, objects: str, **listed: str) -> PaperScene:
    """A scene from its objects and, per relation, pairs "a-b"; what touches the first object comes last."""
    names = tuple(objects.split())
    relations = {"touch": TOUCH, "within": WITHIN, "partial": PARTIAL, "standing": TOUCH}
    found: list[Listed] = []
    for key, text in listed.items():
        for pair in text.split():
            a, b = (pair, names[0]) if key == "standing" else pair.split("-")
            found.append((a, relations[key], b))
    return PaperScene(number, names, tuple(found))


SCENES: Mapping[int, PaperScene] = FrozenDict(
    {
        scene.number: scene
        for scene in (
            _scene(
                1, "ground lying leaning upright",
                touch="leaning-lying upright-lying", standing="lying leaning"
            ),
            _scene(
                2, "ground lying leaning upright",
                touch="leaning-lying upright-lying", standing="lying leaning"
            ),
            _scene(
                3, "ground box book_1 book_2", touch="book_1-box book_2-box book_1-book_2", standing="box"
            ),
            _scene(4, "ground box jar rod", touch="jar-box", partial="rod-jar", standing="box"),
            _scene(
                5, "ground hollow_box solid_box bar", touch="solid_box-hollow_box", partial="bar-hollow_box",
                standing="hollow_box solid_box",
            ),
            _scene(
                6, "ground lying leaning_1 leaning_2 leaning_3 upright",
                touch="leaning_1-lying leaning_2-lying leaning_3-lying upright-lying",
                standing="lying leaning_1 leaning_2 leaning_3",
            ),
            _scene(
                7, "ground lying leaning_1 leaning_2 apart", touch="leaning_1-lying leaning_2-lying",
                standing="lying leaning_1 leaning_2 apart",
            ),
            _scene(
                8, "table bowl strawberry lemon master_chef_can", within="strawberry-bowl",
                partial="lemon-bowl", standing="bowl master_chef_can",
            ),
            _scene(
                9, "table mustard_bottle sugar_box tomato_soup_can lemon", touch="lemon-tomato_soup_can",
                standing="mustard_bottle sugar_box tomato_soup_can",
            ),
            _scene(
                10, "table tuna_can gelatin_box banana chips_can potted_meat_can", touch="banana-tuna_can",
                standing="tuna_can gelatin_box chips_can potted_meat_can",
            ),
            _scene(
                11, "table mug bowl tomato_soup_can orange", partial="orange-bowl",
                standing="mug bowl tomato_soup_can",
            ),
            _scene(
                12, "table plate pear potted_meat_can tomato_soup_can",
                partial="pear-plate potted_meat_can-plate", standing="plate tomato_soup_can",
            ),
            _scene(
                13, "table plate_1 plate_2 plate_3 bowl",
                partial="plate_2-plate_1 plate_3-plate_2 bowl-plate_3", standing="plate_1",
            ),
            _scene(
                14, "table banana_1 banana_2 plum lemon", touch="plum-banana_1 banana_1-banana_2",
                standing="banana_1 banana_2 plum lemon",
            ),
        )
    }
)  # fmt: skip
"""The scenes by number: 55 pairs in 1 to 7, 75 in 8 to 14."""

RGBD = tuple(range(1, 8))
"""Scenes the paper took from few RGB-D images of the IIIT dataset."""
YCB = tuple(range(8, 15))
"""Scenes the paper took from whole surfaces of YCB objects."""

PAPER_6IM, FEATURES, LEARNING, AABB = "paper's 6IM", "feature extraction", "learning", "AABB"

_ACCURACY: Mapping[str, tuple[float, ...]] = {
    PAPER_6IM: (100, 100, 100, 83.3, 83.3, 100, 100, 100, 100, 93.3, 100, 90, 100, 80),
    FEATURES: (66.7, 83.3, 66.7, 83.3, 66.7, 86.7, 60, 90, 100, 93.3, 90, 70, 70, 80),
    LEARNING: (83.3, 83.3, 100, 83.3, 66.7, 60, 60, 80, 90, 86.7, 70, 80, 70, 70),
    AABB: (50, 66.7, 83.3, 66.7, 66.7, 60, 70, 80, 90, 80, 50, 80, 70, 80),
}
_SECONDS: Mapping[str, tuple[float, ...]] = {
    PAPER_6IM: (10.2, 15.8, 27.5, 3.1, 3.5, 55.3, 16.4, 14.6, 13.0, 19.4, 20.1, 14.2, 42.6, 7.8),
    FEATURES: (41.8, 197.9, 116, 12.8, 30.1, 775.6, 304, 365.3, 176, 341.8, 523.2, 305.2, 1033.9, 257),
    LEARNING: (25.7, 44.3, 33.8, 7.9, 13.9, 77.1, 28.4, 12.0, 12.8, 22.3, 24.1, 16.5, 78.1, 9.8),
    AABB: (1.4, 3.0, 2.1, 0.9, 1.4, 4.9, 4.0, 1.6, 1.2, 2.0, 1.2, 1.0, 3.2, 0.7),
}


@dataclass(frozen=True)
class Published:
    """What the paper's Tables 3 and 4 say of one method on one scene.

    Attributes:
        accuracy: Share of pairs that are right [%].
        seconds: Time for all pairs of the scene [s], on the authors' machine.
    """

    accuracy: float
    seconds: float


def published(method: str, number: int) -> Published:
    """The paper's own figures.

    Args:
        method: `PAPER_6IM`, `FEATURES`, `LEARNING` or `AABB`.
        number: Of the scene.
    """
    return Published(_ACCURACY[method][number - 1], _SECONDS[method][number - 1])


def published_right(method: str, numbers: tuple[int, ...]) -> int:
    """Pairs the paper has right on several scenes together, from its percentages."""
    return sum(round(published(method, n).accuracy / 100 * len(SCENES[n].pairs)) for n in numbers)
