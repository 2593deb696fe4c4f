"""What stands between a person and the command: interrupts, its own faults, and what is installed."""
