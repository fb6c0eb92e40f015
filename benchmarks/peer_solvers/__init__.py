"""The default crawler's trajectory by other people's solvers: a file a library, for `benchmarks/peers.py`."""
