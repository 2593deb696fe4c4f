"""One tracker alone: `palpate track`."""
