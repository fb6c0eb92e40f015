"""How the motion of a driven body changes as one of its numbers does: where it is, and how it forgets."""

from .diagram import bifurcation_diagram, BifurcationDiagram

__all__ = ["BifurcationDiagram", "bifurcation_diagram"]
