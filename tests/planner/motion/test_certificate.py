import sys
from pathlib import Path

import numpy as np
import pytest

from topple.planner.motion.certificate import Certifier, MotionBounds, Queries
from topple.planner.motion.collision import Checker
from topple.planner.motion.open_pairs import OpenPairs
from topple.robots.catalog import robot
from topple.robots.collision.separation import Frames
from topple.topology.kernels.compiled import VARIABLE

sys.path.insert(0, str(Path(__file__).parent))
from scenes import box, clutter, densely


def edges(count: int, reach: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    arm = robot("panda")
    rng = np.random.default_rng(seed)
    starts = rng.uniform(arm.lower, arm.upper, (count, 7))
    return starts, starts + reach * (rng.uniform(arm.lower, arm.upper, (count, 7)) - starts)


@pytest.mark.parametrize("seed", range(3))
def test_a_proven_edge_is_free_when_looked_at_densely_and_a_refused_one_is_not(seed):
    checker = Checker(robot("panda"), np.eye(4), clutter(seed))
    starts, ends = edges(40, 0.3, seed)
    found = Certifier(checker).certify(starts, ends)
    assert {certificate.proven for certificate in found} == {True, False}
    for a, b, certificate in zip(starts, ends, found, strict=True):
        dense = checker.free(densely(np.array([a, b])))
        if certificate.proven:
            assert dense.all()
            assert certificate.clearance > 0
        else:
            assert certificate.contact is not None
            assert certificate.state is not None
            assert certificate.contact.distance <= 1e-4
            assert not dense.all() or certificate.contact.distance > -1e-4


def test_the_clearance_asked_for_is_kept():
    scene = clutter(1)
    arm = robot("panda")
    checker = Checker(arm, np.eye(4), scene)
    wide = Checker(arm, np.eye(4), scene, margin=0.02)
    starts, ends = edges(60, 0.2, 5)
    found = Certifier(checker).certify(starts, ends, clearance=0.02)
    proven = [k for k, certificate in enumerate(found) if certificate.proven]
    assert len(proven) > 5
    for k in proven:
        assert found[k].clearance >= 0.02
        assert wide.free(densely(np.array([starts[k], ends[k]]), 0.01)).all()


def test_a_thin_wire_between_the_samples_is_found():
    arm = robot("panda")
    a, b = arm.home.copy(), arm.home.copy()
    a[0], b[0] = -0.5, 0.5
    tips = arm.tool_pose((a + b) / 2)[0, :3, 3]
    wire = {"wire": [box((tips[0], 0.0123, tips[2]), (0.2, 0.0004, 0.0004))]}
    checker = Checker(arm, np.eye(4), wire)
    coarse = Checker(arm, np.eye(4), wire).edge_free(a, b, step=0.5)
    (found,) = Certifier(checker).certify(a[None], b[None])
    assert coarse
    assert not found.proven
    assert found.contact is not None
    assert found.contact.b == "wire"


def test_an_edge_without_length_is_its_state():
    checker = Checker(robot("panda"), np.eye(4), clutter(0))
    home = checker.arm.home
    (found,) = Certifier(checker).certify(home[None], home[None])
    assert found.proven
    assert Certifier(checker).path(home[None]).proven


@pytest.mark.parametrize("path", ["compiled", "numpy"])
def test_no_part_moves_farther_than_its_bound(path, monkeypatch):
    monkeypatch.setenv(VARIABLE, path)
    arm = robot("panda")
    model, rng = Checker(arm, np.eye(4), {}).model, np.random.default_rng(0)
    middle = rng.uniform(arm.lower, arm.upper, (20, 7))
    spans = rng.uniform(0, 0.4, (20, 7))
    frame = model.sets.frame
    assert set(frame.tolist()) >= set(range(8)), "every joint moves one"
    one_of = [int(np.flatnonzero(frame == base)[0]) for base in range(8)]
    pairs = [(part, one_of[base]) for part in model.moving for base in range(frame[part])]
    part, other = (np.repeat(each, 20) for each in np.array(pairs).T)
    state = np.tile(np.arange(20), len(pairs))
    asked = Queries(state, part, other, np.zeros(len(state), dtype=np.float32))
    frames = Frames.of(arm.chain.poses(middle))
    bound, _ = MotionBounds(model, arm.chain).of(frames, spans.astype(np.float32), asked)
    before = arm.chain.frames(middle)
    for _ in range(8):
        after = arm.chain.frames(middle + rng.choice([-1.0, 1.0], (20, 7)) * spans)
        for (part, other), most in zip(pairs, bound.reshape(-1, 20), strict=True):
            moved, stood = (
                seen_from(at, frame[other], frame[part], model.vertices[part]) for at in (after, before)
            )
            assert (np.linalg.norm(moved - stood, axis=2).max(axis=1) <= most + 1e-5).all()


def test_kernels_and_twins_bound_the_same(monkeypatch):
    checker = Checker(robot("panda"), np.eye(4), clutter(2), margin=0.01)
    starts, ends = edges(60, 0.4, 3)
    poses = checker.arm.chain.poses(starts)
    certificates, open_pairs = Certifier(checker).certify(starts, ends), OpenPairs(checker.model)
    states, a, b = open_pairs.among(poses)
    free = checker.free(starts)
    monkeypatch.setenv(VARIABLE, "numpy")
    assert np.abs(checker.arm.chain.poses(starts) - poses).max() < 1e-12
    twins = Certifier(checker).certify(starts, ends)
    assert [one.proven for one in twins] == [one.proven for one in certificates]
    assert {one.proven for one in twins} == {True, False}
    clearances = np.array(
        [[one.clearance, other.clearance] for one, other in zip(twins, certificates, strict=True)]
    )
    assert np.abs(np.diff(clearances, axis=1)).max() < 1e-5
    by_twin = set(zip(*(each.tolist() for each in open_pairs.among(poses)), strict=True))
    assert len(by_twin) > 30
    assert len(by_twin ^ set(zip(states.tolist(), a.tolist(), b.tolist(), strict=True))) <= 2, "but rounding"
    assert (checker.free(starts) == free).all()


def seen_from(frames: np.ndarray, base: int, frame: int, vertices: np.ndarray) -> np.ndarray:
    pose = np.linalg.inv(frames[:, base]) @ frames[:, frame]
    return np.einsum("mij,vj->mvi", pose[:, :3, :3], vertices) + pose[:, None, :3, 3]


def test_an_edge_is_certified_or_its_witness_named():
    arm = robot("panda")
    a, b = arm.home.copy(), arm.home.copy()
    a[0], b[0] = -0.6, 0.6
    free = Certifier(Checker(arm, np.eye(4), {})).certify(a[None], b[None])[0]
    assert free.proven
    assert free.clearance > 0
    post = box((0.3, 0.0, 0.5), (0.02, 0.02, 1.0))
    barred = Certifier(Checker(arm, np.eye(4), {"post": [post]})).certify(a[None], b[None])[0]
    assert not barred.proven
    assert barred.contact is not None
    assert barred.contact.b == "post"
