"""One tree for one solid: normal form, equality, rounded numbers."""
