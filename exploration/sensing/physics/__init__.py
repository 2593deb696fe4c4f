"""The simulated contact: rays to gap, rubber to pressure, electronics to counts; and what the housing meets."""
