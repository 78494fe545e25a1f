"""What the clouds are the surfaces of: completed bodies, their convex parts, their tops."""
