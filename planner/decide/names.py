"""Names for numbers: what a mask's label alone names is called by colour and kind, as "yellow box (7)"."""

import colorsys
import re
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from functools import cached_property
from typing import Any, TypeVar, cast

import msgspec
import numpy as np

from topple.topology.base.values import FrozenDict
from topple.topology.bodies.complete import kind_of
from topple.topology.bodies.surfaces import surfaces_of
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage, Photo

Value = TypeVar("Value")
Colour = tuple[int, int, int]  # red, green, blue, 0..255

EXPOSED = 150.0  # mean over objects of their brightest channel: darker photos are lightened
_GREY = 0.2  # share of its brightest channel by which the channels of a grey differ at most
_BLACK, _WHITE = 0.25, 0.6  # lightness of what is called black at most, and white at least
HUES = {
    "red": 0.0,
    "orange": 0.08,
    "yellow": 0.15,
    "green": 0.36,
    "teal": 0.49,
    "blue": 0.61,
    "purple": 0.77,
    "pink": 0.92,
}
"""Turns of the hue that a word in a name stands for: a cube called green is drawn green."""

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
    return cast("Value", rename(value, spoken_names(scene)))


class SpokenNames(Mapping[str, str]):
    """The names of a scene by number, told once somebody asks: orders of many scenes are never printed."""

    def __init__(self, scene: Scene) -> None:
        """Keep the scene to ask."""
        self._scene = scene

    @cached_property
    def _names(self) -> dict[str, str]:
        return spoken_names(self._scene)

    def __getitem__(self, number: str) -> str:
        return self._names[number]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __reduce__(self) -> tuple[type, tuple[dict[str, str]]]:
        return FrozenDict, (self._names,)


def spoken_names(scene: Scene) -> dict[str, str]:
    """Number of an object's label -> colour of its mask, kind of its body, and the number."""
    numbers = [name for name in scene.names if name.isdigit()]
    if not numbers or scene.up is None:
        return {}
    paints, bodies, names = paints_of(photo_of(scene, every=4)), surfaces_of(scene), dict[str, str]()
    for name in numbers:
        cloud = bodies.upright.clouds[name]
        kind = kind_of(cloud, bodies.sight, bodies.upright.floor_under(cloud))
        words = [colour_word(paints[name])] if name in paints else []
        words = ["support"] if name in scene.fixed else [*words, kind]
        names[name] = f"{' '.join(words)} ({name})"
    return names


def rename(value: Any, names: Mapping[str, str]) -> Any:
    """Put other names into a value, in its sentences too."""
    if not names or type(value).__module__.startswith("topple.robots"):  # whose parts have names of their own
        return value
    if type(value) is str:
        return names.get(value) or _NAMED.sub(lambda m: m[1] + names.get(m[2], m[2]), value)
    if isinstance(value, Mapping):
        pairs = cast("Mapping[Any, Any]", value).items()
        return FrozenDict({rename(key, names): rename(each, names) for key, each in pairs})
    if isinstance(value, (tuple, list, frozenset)):
        made: Any = getattr(type(value), "_make", type(value))
        return made([rename(each, names) for each in cast("tuple[Any, ...]", value)])
    if isinstance(value, msgspec.Struct):
        kept = {key: rename(getattr(value, key), names) for key in value.__struct_fields__}
        return msgspec.structs.replace(value, **kept)
    if not is_dataclass(value):
        return value
    changed: Any = object.__new__(type(value))
    changed.__dict__.update({key: rename(each, names) for key, each in vars(value).items()})
    if isinstance(value, DepthImage):
        labels = {int(number): name for number, name in names.items()}
        changed.__dict__["names"] = FrozenDict(labels | dict(changed.names))
    return changed


def colour_word(colour: Colour) -> str:
    """Say in a word which colour something has: the name of a hue, or black, grey, white or brown."""
    hue, light, _ = colorsys.rgb_to_hls(*np.divide(colour, 255).tolist())
    if max(colour) - min(colour) < _GREY * max(colour) or max(colour) < 255 * _BLACK:
        return "black" if light < _BLACK else "white" if light > _WHITE else "grey"
    word = min(HUES, key=lambda name: abs((hue - HUES[name] + 0.5) % 1.0 - 0.5))
    pale = max(colour) - min(colour) < 2 * _GREY * max(colour) and light < 0.5
    return "brown" if word in ("red", "orange") and pale else word


def photo_of(scene: Scene, every: int = 1) -> Photo | None:
    """The first colour image that a scene came with, of its rows and columns one in so many."""
    for image in scene.images:
        if image.rgb is not None:
            rgb, label = image.rgb[::every, ::every], image.label[::every, ::every]
            numbers = [int(number) for number in np.unique(label) if number > 0]
            return Photo(rgb, label, {number: image.name_of(number) for number in numbers})
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
    gain = np.clip(EXPOSED / max(float(np.mean(bright[named])), 1.0), 1.0, 2.0) if named else 1.0
    gains = np.maximum(gain, np.minimum(EXPOSED / 2 / bright, 2.0))  # in the shade of a shelf, too
    rounded = np.minimum(gains[:, None] * means, 255.0).round().astype(int).tolist()
    return {shown.names[int(numbers[at])]: (rounded[at][0], rounded[at][1], rounded[at][2]) for at in named}
