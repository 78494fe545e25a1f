"""What a scene's files may be: how much they unpack to, asked before it is allocated, and where they lie."""

from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar

from topple.topology.errors import InvalidInput
from topple.topology.io.tolerances import MOST_BYTES

_most: ContextVar[int] = ContextVar("_most", default=MOST_BYTES)
_outside: ContextVar[bool] = ContextVar("_outside", default=False)


@contextmanager
def allowing(size: int | None, outside: bool) -> Generator[None, None, None]:
    """Say in a block what files may be.

    Args:
        size: Bytes that they may unpack to; as before where None.
        outside: Whether `files` of a scene.json may lie elsewhere than below its folder.
    """
    most, away = _most.set(_most.get() if size is None else size), _outside.set(outside)
    try:
        yield
    finally:
        _most.reset(most)
        _outside.reset(away)


def outside_allowed() -> bool:
    """Whether files may lie elsewhere than below the scene's folder."""
    return _outside.get()


def check_size(size: int, what: str) -> None:
    """Refuse what would unpack to more than is allowed.

    Args:
        size: Bytes that it declares, or has.
        what: What it is, for the message.

    Raises:
        InvalidInput: It is too much.
    """
    if not 0 <= size <= _most.get():
        raise InvalidInput(
            f"{what} would unpack to {size / 1e6:.0f} MB, and {_most.get() / 1e6:.0f} MB are allowed: thin "
            "the clouds, or allow more with --max-mb (load_scene(..., most_bytes=))"
        )
