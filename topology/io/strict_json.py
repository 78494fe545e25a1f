"""JSON that says everything once."""

import json
from typing import Any

from topple.topology.errors import InvalidInput


def read_json(text: str, where: str) -> Any:
    """Read a JSON document.

    Args:
        text: The document.
        where: What it is called, for the message.

    Returns:
        Its value.

    Raises:
        InvalidInput: If it is not JSON, or gives a key twice, where json would silently keep the last.
    """

    def without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        known: dict[str, Any] = {}
        for key, value in pairs:
            if key in known:
                raise InvalidInput(f"{where} has the key {key!r} twice: expected each name once")
            known[key] = value
        return known

    try:
        return json.loads(text.removeprefix("\ufeff"), object_pairs_hook=without_doubles)  # as editors begin
    except ValueError as error:  # a number of thousands of digits, too
        raise InvalidInput(f"{where} is not JSON: {error}") from error
    except RecursionError as error:
        raise InvalidInput(f"{where} is nested too deeply to be read") from error
