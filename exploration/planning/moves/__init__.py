"""Moves that close what is open, one file each."""
