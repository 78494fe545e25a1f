"""Arms: their files and what is said of their tools, joints, kinematics and what of them can collide."""
