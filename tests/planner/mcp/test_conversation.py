"""A client of the package `mcp` asks the server over stdio, and whatever it asks stays below the root."""

import json
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from on_table import BASE, on_table

from topple.planner.mcp.root import Root
from topple.planner.mcp.tools import TOOLS, answer, schema_of
from topple.robots import shapes
from topple.topology.base.errors import InvalidInput

MJCF = """<mujoco><worldbody>
<geom name="table" type="box" size="0.5 0.5 0.02" pos="0 0 -0.02"/>
<body name="box" pos="0 0 0.05"><freejoint/><geom type="box" size="0.03 0.03 0.05"/></body>
<body name="block" pos="0 0 0.12"><freejoint/><geom type="box" size="0.02 0.02 0.02"/></body>
</worldbody></mujoco>"""
FREE = {"path": "scene.npz"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A block on a box, and a bowl beside, in a folder with a neighbour that is not served."""
    above, size = tmp_path_factory.mktemp("above"), (0.05, 0.05, 0.1)
    boxes = [(shapes.box("box", size), (0.0, 0.0, 0.0)), (shapes.box("can", size), (0.0, 0.25, 0.0))]
    scene = on_table(*boxes, (shapes.block("block", 0.04), (0.0, 0.0, 0.1)))
    for name in ("served", "beside"):
        (above / name).mkdir()
        np.savez(above / name / "scene.npz", **scene.clouds, fixed=["table"], up=[0, 0, 1], robot_base=BASE)
    (above / "served" / "link.npz").symlink_to(above / "beside" / "scene.npz")
    return above / "served"


def converse(folder: Path, *calls: tuple[str, dict[str, Any]]) -> tuple[list[str], list[Any]]:
    """The tools that there are, and the answer to each call."""
    anyio = pytest.importorskip("anyio", reason="mcp is not installed: pip install '.[mcp]'")
    pytest.importorskip("mcp", reason="mcp is not installed: pip install '.[mcp]'")
    from mcp import Client, StdioServerParameters
    from mcp.client.stdio import stdio_client

    async def talk() -> tuple[list[str], list[Any]]:
        command = ["-W", "ignore", "-m", "topple", "mcp", "--root", str(folder)]
        started = StdioServerParameters(command=sys.executable, args=command, env={**os.environ})
        async with Client(stdio_client(started)) as client:
            tools = [tool.name for tool in (await client.list_tools()).tools]
            return tools, [await client.call_tool(name, arguments) for name, arguments in calls]

    return anyio.run(talk)


def test_a_conversation_of_eight_calls(folder):
    tools, answers = converse(
        folder,
        ("relate", {"scene": FREE}),
        ("order", {"scene": FREE, "targets": ["box"]}),
        ("why", {"scene": FREE, "take": "box"}),
        ("why", {"scene": FREE, "take": "box", "gone": ["block"]}),
        ("check", {"scene": {"mjcf": MJCF}}),
        ("next_view", {"scene": FREE}),
        ("plan", {"scene": FREE, "goal": "free can", "output": "plan.json"}),
        ("verify", {"scene": FREE, "plan": "plan.json"}),
    )
    assert tools == list(TOOLS)
    assert not [each.content[0].text for each in answers if each.is_error]
    assert all(json.loads(each.content[0].text) == each.structured_content for each in answers)
    relations, order, refused, accepted, check, view, plan, checked = (e.structured_content for e in answers)
    pairs = {(p["a"], p["b"]): p["relation"] for p in relations["relations"]}
    assert pairs["box", "block"] == "touch"
    assert order["order"] == ["block", "box"]
    assert not refused["accepted"] and refused["first"] == ["block"]
    assert refused["reason"].startswith("block rests on box")
    proof = refused["certificate"]
    assert [(e["first"], e["then"]) for e in proof["dependencies"]] == [("block", "box")]
    assert [(e["b"], e["swept"]) for e in proof["swept"]] == [("block", True)] and proof["clears"] == ["can"]
    assert {(c["a"], c["b"]) for c in proof["contacts"]} == {("table", "box"), ("box", "block")}
    block = next(each for each in proof["check"] if each["object"] == "block")
    assert block["carried_by"][0]["object"] == "box" and block["carried_by"][0]["newton"] > 0.0
    assert accepted["accepted"] and accepted["certificate"]["swept"] == [] and accepted["gone"] == ["block"]
    assert check["stands"] and {each["object"] for each in check["objects"]} == {"box", "block"}
    assert view == {"next_view": None}, "nothing is hidden where nobody says from where it was seen"
    assert plan["certified"] and [step["object"] for step in plan["steps"]] == ["can"]
    assert checked["ok"] and checked["residuals"]


def ask(folder: Path, name: str, **arguments: Any) -> dict[str, Any]:
    return answer(Root.at(folder), name, arguments)


@pytest.mark.parametrize("path", ["../beside/scene.npz", "link.npz", "/etc/hostname", "a\0b", "../x"])
def test_nothing_outside_the_root_is_read(folder, path):
    with pytest.raises(InvalidInput, match=r"not below the root|no file can be"):
        ask(folder, "relate", scene={"path": path})


def test_nothing_that_a_scene_names_outside_the_root_is_read(folder):
    pytest.importorskip("mujoco")
    (folder / "inner.xml").write_text('<mujoco><asset><mesh file="../beside/a.stl"/></asset></mujoco>')
    for asset in ('<mesh name="a" file="../beside/a.stl"/>', '<model name="a" file="inner.xml"/>'):
        text = MJCF.replace("<worldbody>", f"<asset>{asset}</asset><worldbody>", 1)
        with pytest.raises(InvalidInput, match="not below the root"):
            ask(folder, "relate", scene={"mjcf": text})


@pytest.mark.parametrize(
    ("name", "arguments", "said"),
    [
        ("order", {"scene": {}}, "nothing: give path, clouds or mjcf"),
        ("order", {"scene": {"path": "scene.npz", "mjcf": MJCF}}, "path and mjcf"),
        ("order", {"scene": FREE, "target": "box"}, "unknown field `target`"),
        ("order", {"scene": {"clouds": {"a": [[0.0, 1.0]]}}}, r"clouds"),
        ("why", {"scene": FREE, "take": "bx"}, "did you mean 'box'"),
        ("why", {"scene": FREE, "take": "table"}, "fixed and never moves"),
        ("plan", {"scene": FREE, "goal": "free can", "robot": "../arm.urdf"}, "robot"),
        ("plan", {"scene": FREE, "goal": "free can", "output": "../beside/plan.json"}, "below the root"),
        ("verify", {"scene": FREE, "plan": "../beside/scene.npz"}, "below the root"),
        ("verify", {"scene": FREE, "plan": {}}, "document"),
        ("verify", {"scene": FREE, "plan": "none.json"}, "No such file"),
        ("shell", {}, "no tool 'shell'"),
    ],
)
def test_wrong_calls_are_refused_in_a_line(folder, name, arguments, said):
    with pytest.raises(InvalidInput, match=said):
        ask(folder, name, **arguments)


def test_arrays_are_bounded(folder):
    cloud = [[0.0, 0.0, 0.001 * k] for k in range(100)]
    with pytest.raises(InvalidInput, match="clouds would unpack"):
        answer(Root.at(folder, max_bytes=1000), "relate", {"scene": {"clouds": {"a": cloud}}})


def test_schemas_are_of_objects_without_other_keys():
    schemas = {name: schema_of(name) for name in TOOLS}
    assert all(each["type"] == "object" and not each["additionalProperties"] for each in schemas.values())
    assert schemas["why"]["required"] == ["scene", "take"]


def test_the_command_refuses_a_root_that_is_none(typed):
    assert "no such folder" in typed("mcp", "--root", "nowhere", code=2).err
