import numpy as np
import pytest

from topple.planner.blocking import overlap
from topple.planner.dependency import Dependency, DependencyGraph
from topple.topology import UnknownObject


def slab(x: float, z: float, size: float = 0.1) -> np.ndarray:
    steps = np.arange(0, size, 0.004)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return np.column_stack([grid[:, 0] + x, grid[:, 1], np.full(len(grid), z)])


def test_what_hangs_over_must_be_pushed_aside_by_its_overhang() -> None:
    found = overlap(slab(0.06, 0.1), slab(0.0, 0.0))
    assert found is not None
    assert found.evasion == pytest.approx(0.04, abs=0.006)


def test_above_is_not_below_and_beside_is_neither() -> None:
    assert overlap(slab(0, 0.0), slab(0, 0.1)) is None
    assert overlap(slab(0.2, 0.1), slab(0, 0.0)) is None


def test_what_is_higher_than_the_lift_is_not_met() -> None:
    assert overlap(slab(0, 0.5), slab(0, 0.0)) is None


def test_an_edge_to_nobody_is_refused() -> None:
    with pytest.raises(UnknownObject, match="c"):
        DependencyGraph(("a", "b"), (Dependency("a", "c", "supported", 1.0),))


def test_the_surer_of_two_reasons_stays() -> None:
    edges = [Dependency("a", "b", "leaning", 0.4), Dependency("a", "b", "supported", 0.8)]
    assert DependencyGraph.of(("a", "b"), edges).dependencies == (edges[1],)


def test_cycles_and_ancestors() -> None:
    pairs = (("a", "b"), ("b", "a"), ("b", "c"))
    graph = DependencyGraph(tuple("abcd"), tuple(Dependency(x, y, "leaning", 0.5) for x, y in pairs))
    assert graph.cycles() == (("a", "b"),)
    assert graph.before("c") == {"a", "b"}
    assert graph.before("d") == frozenset()
