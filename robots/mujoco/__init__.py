"""The world on MuJoCo: bodies, an arm with a jaw, and cameras that need no graphics."""
