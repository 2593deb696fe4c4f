"""What `models.generate` draws from: bodies, the sites that are free on them, features, sizes."""
