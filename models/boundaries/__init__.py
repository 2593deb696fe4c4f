"""What a boundary is built from: curves, extents, tangent pieces, connected triangles."""
