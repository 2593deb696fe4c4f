"""What `locate` and `recognize` do between their flags and their answer."""
