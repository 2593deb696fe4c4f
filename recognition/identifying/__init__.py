"""`palpate identify`: touch an object until it is sure which one of a library it is."""
