"""Arrays and stages: simulated, recorded, on a wire."""
