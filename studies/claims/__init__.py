"""The paper, tested: its claims, each with a verdict and the numbers that decide it."""
