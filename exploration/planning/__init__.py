"""What is known so far, and which touch comes next."""
