"""The PyBullet world: bodies, cameras and the simulated arm in it."""
