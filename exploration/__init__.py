"""Sensing, devices, control and planning: how an object is touched."""
