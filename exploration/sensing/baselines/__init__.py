"""Other people's ways to find lines in a tactile image, behind the interface of ours: image -> tuple of lines."""
