"""What can act: arms, grippers, cameras, bodies and the PyBullet world they share."""
