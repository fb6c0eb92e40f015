"""Parts of `benchmarks/mutation.py`: faults made on purpose, and whether the tests notice them."""
