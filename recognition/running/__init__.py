"""One run: the world it touches, what it writes down, when it ends, its folder on disk."""
