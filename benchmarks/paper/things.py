"""The things of scenes 8 to 14: procedural ones of the size of YCB objects, or the real meshes.

Dimensions and masses are those the YCB object set publishes: Calli et al., "Benchmarking in manipulation
research: The YCB object and model set" (IEEE RAM 2015), tables of objects.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from topple.robots import shapes
from topple.robots.world.bodies import Body

Maker = Callable[[str], Body]

GREEN = (0.2, 0.5, 0.3, 1.0)

_PROCEDURAL: Mapping[str, tuple[float, Maker]] = {
    "master_chef_can": (0.414, lambda name: shapes.can(name, diameter=0.102, height=0.139)),
    "sugar_box": (0.514, lambda name: shapes.box(name, (0.038, 0.089, 0.175), color=(0.9, 0.8, 0.3, 1.0))),
    "tomato_soup_can": (0.349, lambda name: shapes.can(name, diameter=0.066, height=0.101)),
    "mustard_bottle": (0.603, shapes.bottle),
    "tuna_can": (0.171, lambda name: shapes.can(name, diameter=0.085, height=0.033)),
    "gelatin_box": (0.097, lambda name: shapes.box(name, (0.028, 0.085, 0.073), color=(0.75, 0.2, 0.3, 1.0))),
    "potted_meat_can": (0.370, shapes.tin),
    "banana": (0.066, shapes.banana),
    "strawberry": (0.018, lambda name: shapes.strawberry(name, diameter=0.0438, length=0.055)),
    "lemon": (0.029, lambda name: shapes.lemon(name, diameter=0.054, length=0.068)),
    "pear": (0.049, lambda name: shapes.pear(name, diameter=0.0662, length=0.100)),
    "orange": (0.047, shapes.orange),
    "plum": (0.025, lambda name: shapes.plum(name, diameter=0.052)),
    "bowl": (0.147, lambda name: shapes.bowl(name, diameter=0.159, height=0.053)),
    "mug": (0.118, lambda name: shapes.mug(name, diameter=0.080, height=0.082)),
    # The 24 mm of the YCB plate; its well lies so high that a third plate stays above the first one's rim.
    "plate": (0.279, lambda name: shapes.plate(name, diameter=0.258, height=0.024, well=0.014)),
    "chips_can": (0.205, lambda name: shapes.can(name, diameter=0.075, height=0.25, color=GREEN)),
}  # fmt: skip

_FOLDERS: Mapping[str, str] = {
    "master_chef_can": "002_master_chef_can", "sugar_box": "004_sugar_box",
    "tomato_soup_can": "005_tomato_soup_can", "mustard_bottle": "006_mustard_bottle",
    "tuna_can": "007_tuna_fish_can", "gelatin_box": "009_gelatin_box",
    "potted_meat_can": "010_potted_meat_can", "banana": "011_banana", "strawberry": "012_strawberry",
    "lemon": "014_lemon", "pear": "016_pear", "orange": "017_orange", "plum": "018_plum", "bowl": "024_bowl",
    "mug": "025_mug", "plate": "029_plate", "chips_can": "001_chips_can",
}  # fmt: skip


@dataclass(frozen=True)
class Things:
    """Where the things come from.

    Attributes:
        models: Folder with one folder per YCB object, named as in the set; None: all are procedural.
    """

    models: Path | None = None

    def make(self, kind: str, name: str | None = None) -> Body:
        """One thing, standing or lying on z = 0.

        Args:
            kind: One of the kinds above.
            name: Its name in the scene; None: its kind.
        """
        if self.models is not None and self.has_model(kind):
            from topple.benchmarks.body_files import body_from_files

            return body_from_files(self.models / _FOLDERS[kind], name or kind)
        mass, make = _PROCEDURAL[kind]
        body = make(name or kind)
        return replace(body, mass=mass, inertia=body.inertia * (mass / body.mass))

    def has_model(self, kind: str) -> bool:
        """Whether the folder holds the real mesh of a kind."""
        return self.models is not None and (self.models / _FOLDERS[kind] / "collision.obj").is_file()

    @property
    def absent(self) -> tuple[str, ...]:
        """Kinds that stay procedural though models are wanted."""
        return () if self.models is None else tuple(k for k in _FOLDERS if not self.has_model(k))
