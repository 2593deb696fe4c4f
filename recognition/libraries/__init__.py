"""What `palpate library` answers."""
