"""Experiments that fill a folder: each a subpackage, with a command of its own."""
