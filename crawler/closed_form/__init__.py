"""Linear bodies: motion by the matrix exponential, event by event."""
