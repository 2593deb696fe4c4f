"""Example parts, a few lines of CSG each."""
