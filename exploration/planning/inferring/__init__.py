"""What the end of exploration infers where no array could lie, and says so."""
