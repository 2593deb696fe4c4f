"""`palpate probe`: one exploratory procedure alone, and what it felt."""
