from importlib.util import find_spec

from hypothesis import settings

settings.register_profile("topple", deadline=None)  # a busy machine is no failure
settings.load_profile("topple")

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
