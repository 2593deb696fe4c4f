"""What arrays say on a wire: pure functions of bytes, one file a protocol."""
