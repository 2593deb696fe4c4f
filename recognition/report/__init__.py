"""Run and report pages: one self-contained file each."""
