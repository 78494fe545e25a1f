"""Cameras that go wrong: each hands on what another one sees, spoilt from some look on."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.views.image import DepthImage


class Eye(Protocol):
    """What takes a picture of a world: a camera, or one that goes wrong."""

    def look(self, world: PhysicalWorld, rng: np.random.Generator | None = None) -> DepthImage:
        """Take a picture."""
        ...


@dataclass
class Spoilt:
    """A camera that goes wrong; this one does not.

    Attributes:
        eye: The camera behind it.
        since: Number of the first look that is spoilt; looks count from zero.
        looks: How many there were.
    """

    eye: Eye
    since: int = 0
    looks: int = 0

    def look(self, world: PhysicalWorld, rng: np.random.Generator | None = None) -> DepthImage:
        """Take a picture, spoilt where it is time."""
        image = self.eye.look(world, rng)
        self.looks += 1
        return self.spoil(image) if self.looks > self.since else self.kept(image)

    def kept(self, image: DepthImage) -> DepthImage:
        """A picture before it is time."""
        return image

    def spoil(self, image: DepthImage) -> DepthImage:
        """What goes wrong with a picture."""
        return image


class Dark(Spoilt):
    """Delivers a picture without a depth and without a mask."""

    def spoil(self, image: DepthImage) -> DepthImage:
        """Nothing in it."""
        return replace(image, depth=np.zeros_like(image.depth), label=np.zeros_like(image.label), names={})


class Millimetres(Spoilt):
    """Delivers depth in millimetres, as many drivers do."""

    def spoil(self, image: DepthImage) -> DepthImage:
        """A thousand times as far."""
        return replace(image, depth=image.depth * 1000.0)


class Late(Spoilt):
    """Delivers the last picture from before again and again."""

    _last: DepthImage | None = None

    def kept(self, image: DepthImage) -> DepthImage:
        """Remember it."""
        self._last = image
        return image

    def spoil(self, image: DepthImage) -> DepthImage:
        """The one remembered."""
        return self._last or image


@dataclass
class Swapped(Spoilt):
    """Calls two objects by each other's names, in one look.

    Attributes:
        pair: Their names.
    """

    pair: tuple[str, str] = ("", "")

    def spoil(self, image: DepthImage) -> DepthImage:
        """The other name, in the first look that is spoilt."""
        if self.looks != self.since + 1:
            return image
        a, b = self.pair
        other = {a: b, b: a}
        return replace(image, names={k: other.get(name, name) for k, name in image.names.items()})


@dataclass
class Split(Spoilt):
    """Takes one object for two, from a line down the middle of its mask.

    Attributes:
        name: Its name; the piece to the right gets a new one.
    """

    name: str = ""

    def spoil(self, image: DepthImage) -> DepthImage:
        """Another label right of the middle."""
        number = next((k for k, name in image.names.items() if name == self.name), None)
        if number is None:
            return image
        columns = np.indices(image.label.shape)[1]
        mask = image.label == number
        right = mask & (columns > np.median(columns[mask]))
        if not right.any():
            return image
        new = max(image.names) + 1
        label = np.where(right, new, image.label)
        return replace(image, label=label, names={**image.names, new: f"{self.name}_piece"})


@dataclass
class Unseen(Spoilt):
    """Does not find the mask of an object any more; its depth is still there.

    Attributes:
        name: The object.
    """

    name: str = ""

    def spoil(self, image: DepthImage) -> DepthImage:
        """Without the label."""
        numbers = [k for k, name in image.names.items() if name == self.name]
        label = np.where(np.isin(image.label, numbers), 0, image.label)
        return replace(
            image, label=label, names={k: name for k, name in image.names.items() if k not in numbers}
        )


@dataclass
class TakenAway(Spoilt):
    """Sees the world after somebody took an object off the table, just before a look.

    Attributes:
        world: The world.
        name: The object.
    """

    world: PhysicalWorld | None = None
    name: str = ""

    def look(self, world: PhysicalWorld, rng: np.random.Generator | None = None) -> DepthImage:
        """Take a picture of what is left."""
        if self.looks == self.since and self.name in world.names:
            world.remove(self.name)
            world.settle()
        return super().look(world, rng)
