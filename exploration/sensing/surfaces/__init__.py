"""The smooth surface under the pad, from one frame."""
