"""A run while it goes on, and a run that has ended, served to a browser of this machine."""
