"""Recordings, written as they happen and replayed as devices."""
