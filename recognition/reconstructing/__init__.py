"""`palpate reconstruct`: a model from evidence that exists."""
