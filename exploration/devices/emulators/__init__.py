"""Arrays and a Grbl stage that answer on pseudo-terminals, with the simulator behind them."""
