"""Many walks: independent jobs of (terrain, selector, seed), kept in a folder as they finish."""
