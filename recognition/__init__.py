"""Assemble, match, decide, report: what was touched, and the command line."""
