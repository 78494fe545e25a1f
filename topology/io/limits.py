"""How much a file may unpack to: bounded before anything is allocated or decompressed."""

from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar

from topple.topology.errors import InvalidInput

MOST_BYTES = 1 << 29
"""Half a gigabyte, some twenty million points: more than any frame of depth cameras, and what a laptop holds
a few times over."""

_most: ContextVar[int] = ContextVar("_most", default=MOST_BYTES)


@contextmanager
def at_most(size: int | None) -> Generator[None, None, None]:
    """Bound what files may unpack to in a block.

    Args:
        size: Bytes; as before where None.
    """
    token = _most.set(_most.get() if size is None else size)
    try:
        yield
    finally:
        _most.reset(token)


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
