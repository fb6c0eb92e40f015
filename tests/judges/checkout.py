"""The checkout that the tests stand in."""

from pathlib import Path

ROOT = Path(__file__).parents[2]

FOLDERS = ("package", *sorted(link.name for link in (ROOT / "package").iterdir() if link.is_symlink()))
"""Folders of the package: its own, and those that are linked into it."""
