"""Arms: their files, joints, kinematics and what of them can collide."""
