"""Ways through space, and round what is in it."""
