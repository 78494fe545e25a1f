"""Names for numbers: what a mask's label alone names is called by colour and kind, as "yellow box (7)"."""

import re
from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any, TypeVar, cast

import msgspec
import numpy as np

from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import Colour, colour_word
from topple.robots.arm.arm import Arm
from topple.topology.base.values import FrozenDict
from topple.topology.bodies.complete import kind_of
from topple.topology.bodies.surfaces import surfaces_of
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage, Photo

Value = TypeVar("Value")

_BEFORE = (
    "above|after|and|before|beside|blocks|by|carries|empty|free|holds?|inside|move|on|or|remove|since|taking|to|"
    "under|until|with|within"
)
_AFTER = (
    "and|are|before|blocks|does|falls|floats|has|have|holds?|is|leans|might|was|on|or|rests|tips|within|would"
)
_NAMED = re.compile(rf"(^|[:;,.] |['(]|\b(?:{_BEFORE}) )(\d+)(?=$|[,:;')]| \(|\.(?!\s*\d)| (?:{_AFTER})\b)")
"""A number in a sentence where a name stands; no count and no measure."""


def spoken(scene: Scene, value: Value) -> Value:
    """Say in a scene, document, plan or run how people call the objects that a label's number names."""
    return cast("Value", _renamed(value, spoken_names(scene)))


def spoken_names(scene: Scene) -> dict[str, str]:
    """Number of an object's label -> colour of its mask, kind of its body, and the number."""
    numbers = [name for name in scene.names if name.isdigit()]
    if not numbers or scene.up is None:
        return {}
    paints, bodies, names = paints_of(photo_of(scene)), surfaces_of(scene), dict[str, str]()
    for name in numbers:
        cloud = bodies.upright.clouds[name]
        kind = kind_of(cloud, bodies.sight, bodies.upright.floor_under(cloud))
        words = [colour_word(paints[name])] if name in paints else []
        words = ["support"] if name in scene.fixed else [*words, kind]
        names[name] = f"{' '.join(words)} ({name})"
    return names


def _renamed(value: Any, names: Mapping[str, str]) -> Any:
    """A value with other names in it, in sentences too."""
    if not names or isinstance(value, Arm):
        return value
    if type(value) is str:
        return names.get(value) or _NAMED.sub(lambda m: m[1] + names.get(m[2], m[2]), value)
    if isinstance(value, Mapping):
        pairs = cast("Mapping[Any, Any]", value).items()
        return FrozenDict({_renamed(key, names): _renamed(each, names) for key, each in pairs})
    if isinstance(value, (tuple, list, frozenset)):
        made: Any = getattr(type(value), "_make", type(value))
        return made([_renamed(each, names) for each in cast("tuple[Any, ...]", value)])
    if isinstance(value, msgspec.Struct):
        kept = {key: _renamed(getattr(value, key), names) for key in value.__struct_fields__}
        return msgspec.structs.replace(value, **kept)
    if not is_dataclass(value):
        return value
    changed: Any = object.__new__(type(value))
    changed.__dict__.update({key: _renamed(each, names) for key, each in vars(value).items()})
    if isinstance(value, DepthImage):
        labels = {int(number): name for number, name in names.items()}
        changed.__dict__["names"] = FrozenDict(labels | dict(changed.names))
    return changed


def photo_of(scene: Scene) -> Photo | None:
    """The first colour image that a scene came with."""
    for image in scene.images:
        if image.rgb is not None:
            numbers = [int(number) for number in np.unique(image.label) if number > 0]
            return Photo(image.rgb, image.label, {number: image.name_of(number) for number in numbers})
    return None


def paints_of(shown: Photo | None) -> dict[str, Colour]:
    """Mean colours of the masks in a photo, by name."""
    if shown is None:
        return {}
    label = shown.label.ravel()
    numbers, places, counts = np.unique(label, return_inverse=True, return_counts=True)
    sums = [np.bincount(places.ravel(), shown.rgb[..., axis].ravel()) for axis in range(3)]
    means = np.stack(sums, axis=1) / counts[:, None]
    named = [place for place, number in enumerate(numbers.tolist()) if number in shown.names]
    bright = np.maximum(means.max(axis=1), 1.0)
    gain = np.clip(LIMITS.exposed / max(float(np.mean(bright[named])), 1.0), 1.0, 2.0) if named else 1.0
    gains = np.maximum(gain, np.minimum(LIMITS.exposed / 2 / bright, 2.0))  # in the shade of a shelf, too
    rounded = np.minimum(gains[:, None] * means, 255.0).round().astype(int).tolist()
    return {shown.names[int(numbers[at])]: (rounded[at][0], rounded[at][1], rounded[at][2]) for at in named}
