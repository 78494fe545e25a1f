"""How likely taking one thing moves another."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from topple.benchmarks.chances import LOOKS, fitted, given
from topple.benchmarks.truth.cases import drawn, few, training
from topple.planner.decide.chances import SIGNS, chances, seen_by, weights
from topple.planner.decide.dependency import edges_of
from topple.planner.decide.disturbance import Disturbance
from topple.topology.statics.sweep import Overlap

HANGS = Overlap(evasion=0.03, area=0.002, broad=0.002, places=np.zeros((1, 3)))
FOUND = Disturbance(over=HANGS, seen=HANGS, unheld=0.5, up=0.5, depth=0.0)


def chance(found: Disturbance, view: str, height: float = 0.03) -> float:
    return chances({("a", "b"): replace(found, ahead=(height, height))}, view)["a", "b"]


@pytest.mark.parametrize("view", weights())
def test_no_sign_of_a_disturbance_makes_it_less_likely(view):
    weaker = (
        replace(FOUND, over=None),
        replace(FOUND, seen=None),
        replace(FOUND, unheld=0.1),
        replace(FOUND, up=None),
        replace(FOUND, depth=0.02),
    )
    assert all(chance(each, view) <= chance(FOUND, view) for each in weaker)
    assert "off" in view or all(chance(each, view) < chance(FOUND, view) for each in weaker)
    assert chance(FOUND, view, -0.03) < chance(FOUND, view)


def test_that_it_is_higher_up_shows_no_dependency():
    beside = Disturbance(over=None, seen=None, unheld=0.0, up=None, depth=0.0)
    asked = {("a", "b"): beside, ("b", "a"): replace(beside, up=0.8), ("a", "c"): replace(beside, seen=HANGS)}
    assert edges_of(asked, dict.fromkeys(asked, 0.9), 1) == [("b", "a"), ("a", "c")]
    assert edges_of(asked, dict.fromkeys(asked, 0.2), 1) == []
    assert edges_of({**asked, ("b", "c"): FOUND}, dict.fromkeys((*asked, ("b", "c")), 0.9), 0) == [("b", "c")]


def test_what_falls_either_way_holds_each_other_if_several_cameras_say_so():
    leans = Disturbance(over=None, seen=None, unheld=0.4, up=0.1, depth=0.0)
    asked = {("a", "b"): leans, ("b", "a"): replace(leans, up=-0.1)}

    def counted(view: str, found: dict[tuple[str, str], Disturbance]) -> list[tuple[str, str]]:
        return edges_of(found, chances(found, view), 3)

    assert counted("several", asked) == counted("several, clouds", asked) == list(asked)
    assert counted("one", asked) == []  # one camera sees half of either
    stands, rests = replace(leans, unheld=0.0), replace(leans, up=-0.9)
    assert counted("several", {**asked, ("a", "b"): stands}) == []
    assert ("b", "a") not in counted("several", {("a", "b"): replace(leans, up=0.9), ("b", "a"): rests})


def test_every_view_has_its_weights():
    seen = [seen_by(given(training()[0], *look)) for look in LOOKS]
    assert sorted(seen) == sorted(weights())
    assert all(len(each) == len(SIGNS) for each in weights().values())


def test_the_fit_finds_the_weights_that_labels_were_drawn_with():
    rng = np.random.default_rng(0)
    true = np.array([-3.0, 0.8, 1.5, 0.5, 0.4, 0.3, -1.0, 0.3, 0.6, 0.5, -0.7, 0.2, 0.4, 0.6])
    signs = np.column_stack([np.ones(40_000), rng.uniform(0, 2, (40_000, len(SIGNS) - 1))])
    labels = (rng.random(len(signs)) < expit(signs @ true)).astype(float)
    found = fitted([(signs[:9000], labels[:9000]), (signs[9000:], labels[9000:])])
    assert np.allclose(found, true, atol=0.2)
    assert fitted([(signs, 1.0 - labels)])[1:5] == [0.0] * 4, "a sign speaks against what it is a sign of"


def test_no_version_is_judged_on_scenes_that_taught_chances():
    taught = {scene.name for scene in training()}
    assert taught.isdisjoint(scene.name for scene in few())
    assert all(taught.isdisjoint(scene.name for scene in drawn(commit)) for commit in ("a2ac90c", "f65314a"))
