"""From one arrangement to another: the fewest moves and buffers, with a bound that proves it."""
