"""JSON that says everything once."""

import json
from math import isfinite
from typing import Any

from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import check_size
from topple.topology.io.tolerances import VALUE_BYTES


def read_json(text: str | bytes, where: str) -> Any:
    """Read a JSON document.

    Args:
        text: The document, bytes as UTF-8.
        where: What it is called, for the message.

    Returns:
        Its value.

    Raises:
        InvalidInput: If it is not JSON, holds NaN or a number beyond all floats, gives a key twice, where
            json would silently keep the last, or would unpack to more than is allowed.
    """

    def without_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        known: dict[str, Any] = {}
        for key, value in pairs:
            if key in known:
                raise InvalidInput(f"{where} has the key {key!r} twice: expected each name once")
            known[key] = value
        return known

    try:
        text = text.decode("utf-8") if isinstance(text, bytes) else text
        check_size(VALUE_BYTES * (text.count(",") + text.count("[") + text.count("{")), where)
        return json.loads(
            text.removeprefix("\ufeff"),  # as editors begin
            object_pairs_hook=without_doubles, parse_constant=_finite, parse_float=_finite,
        )  # fmt: skip
    except ValueError as error:  # a number of thousands of digits, too
        raise InvalidInput(f"{where} is not JSON: {error}") from error
    except RecursionError as error:
        raise InvalidInput(f"{where} is nested too deeply to be read") from error


def _finite(text: str) -> float:
    value = float(text)
    if not isfinite(value):
        raise ValueError(f"{text} is no number of JSON")
    return value
