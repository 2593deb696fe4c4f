"""The pad among what is known: where it has room, how it comes down there, and what that tells."""
