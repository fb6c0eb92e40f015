"""What `benchmarks/accuracy_worth.py` is made of."""
