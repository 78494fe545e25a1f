"""Arms: their files, tools, joints and kinematics, and which of their parts can collide."""
