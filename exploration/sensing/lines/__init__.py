"""Straight edges and arcs in one frame."""
