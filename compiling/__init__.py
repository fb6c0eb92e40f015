"""Python to machine code: compilation, kept kernels, traced straight-line code, vectors."""
