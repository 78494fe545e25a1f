import signal
from collections import Counter
from importlib.util import find_spec
from pathlib import Path

from hypothesis import settings
from pytest import Item

settings.register_profile("topple", deadline=None)  # a busy machine is no failure
settings.load_profile("topple")

# What a shell starts in the background ignores interrupts, and so would every program that a test interrupts.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Where PyBullet has no wheel, only what does not simulate is tested: these look through simulated cameras.
SIMULATED = [
    "topology/test_containers.py",
    "topology/io/test_bag.py",
    "topology/io/test_bop.py",
    "topology/rule/test_facing.py",
    "topology/statics/test_hidden.py",
    "topology/statics/test_holding.py",
]
collect_ignore = [] if find_spec("pybullet") else SIMULATED


def pytest_collection_modifyitems(items: list[Item]) -> None:
    """Begin with the files that take longest: all of what is left at the end goes to idle processes."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: (item.path.parent != Path(__file__).parent, -slow[item.path]))
