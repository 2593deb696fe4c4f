"""A CSG tree as triangles, to a stated tolerance."""
