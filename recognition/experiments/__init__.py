"""Experiments: a suite file becomes trials, trials become rows, rows become tables and pages."""
