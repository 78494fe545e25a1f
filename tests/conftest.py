from importlib.util import find_spec

# Where PyBullet has no wheel, only what does not simulate is tested: these look through simulated cameras.
SIMULATED = ["topology/test_containers.py", "topology/rule/test_facing.py", "topology/statics/test_hidden.py"]
collect_ignore = [] if find_spec("pybullet") else SIMULATED
