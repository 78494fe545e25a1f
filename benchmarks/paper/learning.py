"""Relations learned from contact points: support vectors between two clouds, clusters of what they look like.

After Rosman and Ramamoorthy, "Learning spatial relationships between objects" (IJRR 2011), as far as the
paper describes it: a support vector machine tells the points of two objects apart, its support vectors
are the points where they meet, and clusters (k-means) of how these lie to each other stand for relations.
Trained on seeded piles, never on a scored scene; what is true of a pile is measured on its bodies.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from topple.benchmarks.paper.stage import CONTACT, STICKS_OUT, gap
from topple.benchmarks.piles import Pile, make_pile, observe
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.errors import NotInstalled
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

FIRST_PILE = 7_900_000
"""Seed of the first training pile, away from all other collections."""
HOLLOW = frozenset({"bowl", "mug", "plate", "tray"})
"""Kinds of the piles that hold things."""
POINTS = 150
"""Points per cloud that the support vector machine sees, the nearest to the other cloud."""
PENALTY = 1.0
"""Of a point on the wrong side, per centimetre."""
STEPS = 5000
"""Of the solver: surfaces that lie in each other cannot be told apart, however long it goes on."""
CLUSTERS = 16
"""Centres of k-means: several per relation, as there are several ways to touch."""
INSTALL = str(NotInstalled("the learning column needs scikit-learn", "bench"))

Example = tuple[FloatArray, str]
"""Features of an ordered pair and its relation."""


@dataclass(frozen=True, eq=False)
class Learned:
    """Clusters of contact points with their relation.

    Attributes:
        mean: (F,) of the training features.
        spread: (F,) their standard deviations.
        centres: (K, F) cluster centres, standardised.
        relations: The relation that most examples of each cluster have.
    """

    mean: FloatArray
    spread: FloatArray
    centres: FloatArray
    relations: tuple[Relation, ...]

    def __call__(self, scene: Scene) -> Mapping[tuple[str, str], Relation]:
        """One relation per pair, by the nearest cluster."""
        return {
            (a, b): self.relations[self._cluster(features(scene.clouds[a], scene.clouds[b], _up(scene)))]
            for a, b in combinations(scene.names, 2)
        }

    def _cluster(self, one: FloatArray) -> int:
        standard = (one - self.mean) / self.spread
        return int(np.argmin(np.linalg.norm(self.centres - standard, axis=1)))


def available() -> bool:
    """Whether scikit-learn is installed."""
    from importlib.util import find_spec

    return find_spec("sklearn") is not None


def train(examples: list[Example], seed: int = 0) -> Learned:
    """Cluster the training pairs.

    Args:
        examples: Features and relations.
        seed: Of k-means.

    Returns:
        What was learned.
    """
    from sklearn.cluster import KMeans

    table = np.array([example for example, _ in examples])
    mean, spread = table.mean(axis=0), np.maximum(table.std(axis=0), 1e-9)
    found: Any = KMeans(n_clusters=min(CLUSTERS, len(table)), random_state=seed).fit((table - mean) / spread)
    labels: IntArray = np.asarray(found.labels_)
    names = np.array([relation for _, relation in examples])
    relations: list[Relation] = []
    for cluster in range(len(found.cluster_centers_)):
        values, counts = np.unique(names[labels == cluster], return_counts=True)
        relations.append(Relation(str(values[np.argmax(counts)])))
    return Learned(mean, spread, np.asarray(found.cluster_centers_), tuple(relations))


def examples_of(seed: int) -> list[Example]:
    """Every pair of one pile, both ways round, whole and from two cameras.

    Args:
        seed: Of the pile; `FIRST_PILE` and on.
    """
    pile = make_pile(seed)
    truth = pile_truth(pile)
    found: list[Example] = []
    for cameras in (0, 2):
        scene = observe(pile, cameras, seed)
        for a, b in combinations(scene.names, 2):
            relation = truth[a, b]
            found.append((features(scene.clouds[a], scene.clouds[b], _up(scene)), str(relation)))
            found.append((features(scene.clouds[b], scene.clouds[a], _up(scene)), str(relation.converse)))
    return found


def pile_truth(pile: Pile) -> dict[tuple[str, str], Relation]:
    """Relations of a pile's bodies: which ones touch, and which one reaches into a hollow one."""
    with pile.world() as world:
        world.step()
        found: dict[tuple[str, str], Relation] = {}
        for a, b in combinations(world.names, 2):
            relation = Relation.DISJOINT
            if gap(world, a, b) <= CONTACT:
                held, holds = _held(world, a, b), _held(world, b, a)
                relation = held or (holds.converse if holds is not None else Relation.TOUCH)
            found[a, b], found[b, a] = relation, relation.converse
    return found


def _held(world: World, content: str, container: str) -> Relation | None:
    """Within or partial within where a thing reaches into a hollow one that stands upright."""
    if world.body(container).kind not in HOLLOW or world.pose(container)[2, 2] < 0.9:
        return None
    inner, outer = np.concatenate(world.parts(content)), np.concatenate(world.parts(container))
    rim = float(outer[:, 2].max())
    lowest = inner[inner[:, 2].argmin()]
    if lowest[2] > rim - STICKS_OUT:
        return None
    if (lowest[:2] < outer[:, :2].min(axis=0)).any() or (lowest[:2] > outer[:, :2].max(axis=0)).any():
        return None
    return Relation.WITHIN if inner[:, 2].max() <= rim else Relation.PARTIAL_WITHIN


def features(a: FloatArray, b: FloatArray, up: FloatArray) -> FloatArray:
    """How the contact points of two clouds lie to each other.

    Args:
        a: (N, 3) points [m].
        b: (M, 3) points [m].
        up: (3,) unit vector.

    Returns:
        (8,) distance of the nearest contact points, its share along `up`, spread of the contact points across
        and along `up`, shares of support vectors on either side, and height of the contact in a and in b.
    """
    from scipy.spatial import KDTree
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.svm import SVC

    near_a = a[np.argsort(np.asarray(KDTree(b).query(a)[0]))[:POINTS]]
    near_b = b[np.argsort(np.asarray(KDTree(a).query(b)[0]))[:POINTS]]
    points = np.concatenate([near_a, near_b])
    middle = points.mean(axis=0)
    side = np.repeat([0, 1], [len(near_a), len(near_b)])
    machine: Any = SVC(kernel="linear", C=PENALTY, max_iter=STEPS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        machine.fit((points - middle) * 100, side)  # [cm]
    chosen: IntArray = np.asarray(machine.support_)
    contact = points[chosen]
    one, other = contact[side[chosen] == 0], contact[side[chosen] == 1]
    distance, index = KDTree(other).query(one)
    nearest = int(np.argmin(distance))
    link = other[int(np.asarray(index)[nearest])] - one[nearest]
    away = max(float(np.linalg.norm(link)), 1e-6)
    height = contact @ up
    low_a, low_b = np.quantile(a @ up, [0.02, 0.98]), np.quantile(b @ up, [0.02, 0.98])
    return np.array(
        [
            np.log10(away + 1e-3),
            float(link @ up) / away,
            float(np.linalg.norm((contact - np.outer(height, up)).std(axis=0))),
            float(height.std()),
            len(one) / len(near_a),
            len(other) / len(near_b),
            (float(height.mean()) - low_a[0]) / max(float(np.ptp(low_a)), 0.005),
            (float(height.mean()) - low_b[0]) / max(float(np.ptp(low_b)), 0.005),
        ]
    )


def _up(scene: Scene) -> FloatArray:
    return np.array([0.0, 0.0, 1.0]) if scene.up is None else scene.up
