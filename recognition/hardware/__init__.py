"""Arrays and stages on a wire: their configs, a world of devices, and their emulators."""
