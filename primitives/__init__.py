"""Geometry, evidence, curvature and fits: what every other package stands on."""
