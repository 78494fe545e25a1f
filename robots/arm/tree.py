"""The joints of a URDF as a tree, before its meshes are read."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

from topple.topology.base.errors import InvalidInput


@dataclass(frozen=True)
class Edge:
    """A joint of the tree.

    Attributes:
        joint: Its name.
        kind: revolute, continuous, prismatic, fixed, or another.
        parent: Its parent link.
        child: Its child link.
        follows: The joint that it mimics, if any.
    """

    joint: str
    kind: str
    parent: str
    child: str
    follows: str | None

    @property
    def moves(self) -> bool:
        """Whether it is not fixed."""
        return self.kind != "fixed"


class Tree:
    """The joints of a URDF, before its meshes are read.

    Args:
        robot: The `<robot>` element.
        name: What to call the file in messages.
    """

    def __init__(self, robot: ElementTree.Element, name: str) -> None:
        self.name = name
        self.edges: dict[str, Edge] = {}
        for element in robot.findall("joint"):
            parent, child, mimic = element.find("parent"), element.find("child"), element.find("mimic")
            if parent is None or child is None:
                raise InvalidInput(f"{name}: joint {element.get('name')!r} has no parent or no child")
            follows = None if mimic is None else str(mimic.get("joint"))
            edge = Edge(
                str(element.get("name")), str(element.get("type")), str(parent.get("link")),
                str(child.get("link")), follows,
            )  # fmt: skip
            self.edges[edge.child] = edge
        self.links = [str(element.get("name")) for element in robot.findall("link")]
        self.bare = {str(e.get("name")) for e in robot.findall("link") if e.find("*/geometry") is None}
        self._children: dict[str, list[Edge]] = {}
        for edge in self.edges.values():
            self._children.setdefault(edge.parent, []).append(edge)

    @property
    def root(self) -> str | None:
        """The one link without a parent; None where there is none, or several."""
        roots = [link for link in self.links if link not in self.edges]
        return roots[0] if len(roots) == 1 else None

    def edge(self, joint: str) -> Edge | None:
        """The joint called `joint`, None where there is none."""
        return next((edge for edge in self.edges.values() if edge.joint == joint), None)

    def below(self, link: str) -> list[Edge]:
        """The joints that hang on a link, directly or not, parents first."""
        found, waiting = list[Edge](), [link]
        while waiting:
            hanging = self._children.get(waiting.pop(), [])
            found += hanging
            waiting += [edge.child for edge in hanging]
            if len(found) > len(self.edges):  # a loop: reading the tree names it
                break
        return found

    def above(self, link: str) -> list[Edge]:
        """The joints from the root to a link, root first."""
        path: list[Edge] = []
        while link in self.edges and len(path) <= len(self.edges):
            path.append(self.edges[link])
            link = path[-1].parent
        return path[::-1]

    def branches(self, link: str) -> list[Edge]:
        """The joints of a link at or beyond which something moves."""
        return [e for e in self._children.get(link, []) if any(b.moves for b in (e, *self.below(e.child)))]

    def series(self, edge: Edge) -> int:
        """How many joints move of their own, one after the other, in the longest branch from a joint on."""
        own = int(edge.moves and edge.follows is None)
        return own + max((self.series(e) for e in self._children.get(edge.child, [])), default=0)
