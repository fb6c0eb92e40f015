"""What the body is: its groups, its scene, its actuator, its state, and the forces on it."""
