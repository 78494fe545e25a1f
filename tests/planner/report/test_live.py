"""The live page: it starts, serves, answers its sliders and closes, without a display."""

import json
import signal
import socket
import subprocess
import sys
import urllib.request
from contextlib import closing

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed: pip install '.[view]'")
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the server's own libraries

from topple.planner.report.live import LivePage  # noqa: E402
from topple.topology.base.errors import InvalidInput  # noqa: E402
from topple.topology.relations.relate import relate  # noqa: E402


def free_port() -> int:
    with closing(socket.socket()) as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


def fetched(url: str) -> str:
    with urllib.request.urlopen(url, timeout=20) as answer:
        assert answer.status == 200
        return answer.read().decode("utf-8", "replace")


def test_it_serves_answers_its_sliders_and_closes(stack):
    scene, relations, _ = stack
    page = LivePage(scene, port=free_port())
    try:
        assert "<html" in fetched(page.url).lower()
        assert page.relations.deviation == relations.deviation
        page.show_deviation(0.02)
        assert page.relations.deviation == 0.02
        assert len(page._lines) == sum(str(pair.relation) != "disjoint" for pair in page.relations)
        assert [name for name, _ in page.moves][-1] != "table" and len(page.moves) == len(scene.movable)
        page.show_step(1)
        first = page.moves[0][0]
        assert [name for name, shown in page._objects.items() if not shown.visible] == [first]
        page.show_step(99)
        assert page.step == len(page.moves)
        page.show_step(0)
        assert all(shown.visible for shown in page._objects.values())
    finally:
        url = page.url
        page.close()
    with pytest.raises(OSError):
        fetched(url)


def test_the_rule_and_the_orderer_that_are_named_are_used(stack):
    from topple.planner.decide.arrange import arrange
    from topple.planner.decide.dependency import DependencyGraph

    def backwards(situation, targets, **_):
        names = tuple(reversed(situation.movable))
        return arrange(DependencyGraph(names, ()), targets, {name: [0, 0, k] for k, name in enumerate(names)})

    scene = stack[0]
    page = LivePage(scene, rule="plain", orderer=backwards, port=free_port())
    try:
        assert page.relations.deviation == 0.002  # the paper's
        assert [name for name, _ in page.moves] == list(scene.movable)
        page.show_deviation(0.004)
        assert page.relations == relate(scene, 0.004, plain=True)
    finally:
        page.close()


def test_steps_of_a_plan_put_things_where_they_go(stack):
    from topple.planner.formats.plan_structs import GraspData, PlacementData, Step
    from topple.planner.planning.plan_format import Plan

    aside = np.eye(4)
    aside[0, 3] = 0.3
    grasp = GraspData("pinch", np.eye(4).tolist(), 0.1, 1.0)
    step = Step("tin", "remove", "", [], grasp, PlacementData(aside.tolist()), [])
    plan = Plan(
        goal="", robot="panda", joints=[], seed=0, pose_base_to_world=np.eye(4).tolist(), base_searched=False,
        q_start=[], order=["tin"], dependencies=[], steps=[step, step],
    )  # fmt: skip
    page = LivePage(stack[0], plan, port=free_port())
    try:
        page.show_step(2)
        tin = page._objects["tin"]
        assert tin.position == pytest.approx([0.6, 0, 0]) and tin.wxyz == pytest.approx([1, 0, 0, 0])
    finally:
        page.close()


def test_an_arm_stands_as_the_plan_begins_and_plays_it(lone_plan):
    plan, scene = lone_plan
    page = LivePage(scene, plan, port=free_port())
    try:
        link, hand = page._arm[-1]
        before = hand.position.copy()
        np.testing.assert_allclose(before, page._motion.links[0, link, :3, 3])
        page.show_time(1e3)
        assert np.linalg.norm(hand.position - page._motion.links[-1, link, :3, 3]) < 1e-9
        np.testing.assert_allclose(page._objects["box"].position, page._motion.carried["box"][-1, :3, 3])
        page.show_step(0)
        np.testing.assert_allclose(hand.position, before)
        page.show_reason("box")
        assert (
            page._why.content == f"**box**: {page.reasons['box']}"
            and plan.steps[0].reason[1:] in page.reasons["box"]
        )
    finally:
        page.close()


def test_the_order_plays_to_its_end_and_names_are_no_markup(stack):
    page = LivePage(stack[0], port=free_port())
    try:
        page._steps.value = len(page.moves) - 1
        page.play(page._steps)
        assert page._steps.value == len(page.moves)
        assert page._cell("a|b*<i>") == "a\\|b\\*\\<i\\>"
    finally:
        page.close()


def test_the_command_says_where_it_is_and_ends_with_an_interrupt(tmp_path, stack):
    scene, port = stack[0], free_port()
    clouds = {f"o{k}" if k else "table": cloud for k, cloud in enumerate(scene.clouds.values())}
    np.savez(tmp_path / "s.npz", up=[0, 0, 1], fixed=["table"], **clouds)
    call = [sys.executable, "-m", "topple", "view", str(tmp_path / "s.npz"), "--port", str(port), "--json"]
    with subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as serving:
        assert serving.stdout is not None
        document = json.loads(serving.stdout.readline())
        assert document["format"] == "topple.view" and "<html" in fetched(document["url"]).lower()
        serving.send_signal(signal.SIGINT)
        assert serving.wait(20) == 0


def test_without_viser_its_extra_is_named(monkeypatch, stack):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InvalidInput, match=r"needs viser: pip install 'viser>=1\.0'$"):
        LivePage(stack[0])
