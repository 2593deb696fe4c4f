"""What is still open: surface that goes on, edges with one face, rims, mouths, and sides not seen."""
