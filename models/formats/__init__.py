"""Readers and writers, one file for each outside format."""
