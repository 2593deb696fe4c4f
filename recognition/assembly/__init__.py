"""From a patch graph to a boundary and a CSG tree."""
