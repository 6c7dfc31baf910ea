"""Physics: what a foothold is worth when a robot stands on it."""
