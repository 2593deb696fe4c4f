"""Small guarded motions that each return evidence."""
