"""What topple can do, measured on this machine, each figure with a baseline beside it."""
