"""The primitives of a CSG tree, with their exact distances."""
