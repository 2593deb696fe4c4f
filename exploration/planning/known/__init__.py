"""What is known of space so far: surface that was touched, and room that was found empty."""
