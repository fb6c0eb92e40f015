"""What makes a smooth step: sets of polynomials, by Taylor series or by Radau IIA."""
