"""Recordings understood frame by frame: `palpate frames`."""
