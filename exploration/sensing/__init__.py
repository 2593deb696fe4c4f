"""Frames, sensor physics, edges, lines and contacts."""
