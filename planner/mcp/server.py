"""The server: tools over stdin and stdout, by the package `mcp`."""

import json
import logging
from functools import partial
from inspect import getdoc
from typing import TYPE_CHECKING, Any

from topple.planner.mcp.root import Root
from topple.planner.mcp.tools import TOOLS, answer, schema_of
from topple.planner.tolerances import MOST_ANSWER
from topple.topology.base.errors import DISTRIBUTION, InvalidInput, NotInstalled, ToppleError

if TYPE_CHECKING:
    from mcp.server import Server
    from mcp.types import CallToolResult

_INSTRUCTIONS = (
    "topple says what a robot can safely take next from a cluttered scene. Put proposals to `why`: it "
    "accepts or refuses each, with contacts, forces and the relation of the swept object. Lengths in metres."
)


def serve(root: Root) -> None:
    """Serve until stdin ends.

    Args:
        root: The folder that is served: no scene or plan is read or written elsewhere.

    Raises:
        NotInstalled: The package mcp is not there.
    """
    try:
        import anyio
        from mcp.server.stdio import stdio_server
    except ModuleNotFoundError as error:
        raise NotInstalled("the server needs mcp", "mcp") from error
    made = server(root)

    async def run() -> None:
        async with stdio_server() as (incoming, outgoing):
            await made.run(incoming, outgoing, made.create_initialization_options())

    anyio.run(run)


def server(root: Root) -> "Server[Any]":
    """A server of the tools; calls are answered one after the other, beside what keeps the connection up."""
    from importlib.metadata import version

    import anyio
    from anyio.to_thread import run_sync
    from mcp import types
    from mcp.server import Server

    alone = anyio.CapacityLimiter(1)

    async def list_tools(*_: object) -> types.ListToolsResult:
        told = [(name, getdoc(tool), schema_of(name)) for name, tool in TOOLS.items()]
        tools = [types.Tool(name=each[0], description=each[1], input_schema=each[2]) for each in told]
        return types.ListToolsResult(tools=tools)

    async def call_tool(_: object, asked: types.CallToolRequestParams) -> types.CallToolResult:
        call = partial(_call, root, asked.name, asked.arguments or {})
        return await run_sync(call, limiter=alone)

    return Server(
        "topple", version=version(DISTRIBUTION), instructions=_INSTRUCTIONS,
        on_list_tools=list_tools, on_call_tool=call_tool,
    )  # fmt: skip


def _call(root: Root, name: str, arguments: dict[str, Any]) -> "CallToolResult":
    """Answer a call, or say in one line why there is no answer."""
    from mcp.types import CallToolResult, TextContent

    try:
        found = answer(root, name, arguments)
        if len(text := json.dumps(found, allow_nan=False)) > MOST_ANSWER:
            raise InvalidInput(f"the answer has {len(text):,} bytes: ask about fewer objects")
        return CallToolResult(content=[TextContent(text=text)], structured_content=found)
    except ToppleError as error:
        words = str(error)
    except Exception as error:  # what nobody foresaw must not end the server
        logging.getLogger(__name__).exception("a call of %s failed", name)
        words = f"a fault of topple itself, please report it ({type(error).__name__}: {error})"
    return CallToolResult(content=[TextContent(text=words)], is_error=True)
