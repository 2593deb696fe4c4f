"""Whether two boundaries are one, and by which motion."""
