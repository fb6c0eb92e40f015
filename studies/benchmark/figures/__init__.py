"""Figures of a benchmark: scores and differences, sweeps, capacities by delay and by degree, and predictions."""

from .capacities import plot_information, plot_profiles
from .predictions import plot_predictions
from .scores import plot_scores
from .sweeps import plot_sweep

__all__ = ["plot_information", "plot_predictions", "plot_profiles", "plot_scores", "plot_sweep"]
