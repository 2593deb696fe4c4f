"""Servo laws, trackers and exploratory procedures."""
