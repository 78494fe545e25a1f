"""Assertions for the tests of those who make scenes: `topple.testing`."""

from topple.planner.stability.check import check
from topple.topology.io.load import AnyScene


def assert_stands(scene: AnyScene) -> None:
    """Fail unless everything in a scene stays where it is.

    Args:
        scene: A scene that knows where up is, or the path of one.

    Raises:
        AssertionError: Something does not stand; says what, why, and by how much.
        InvalidInput: The scene cannot be read, has no `up`, or nothing in it can move.
    """
    __tracebackhide__ = True  # of pytest: the line of the test is what matters
    found = check(scene, margins=False)
    if not found.stands:
        raise AssertionError(found.sentence())
