"""What to do: dependency graph, safe order, grasps, motions, plans, runs and the command line."""
