"""Gymnasium environments of the crawler."""

from .multi_objective import StickSlipCrawlerMOEnv, StickSlipCrawlerMOVectorEnv
from .rendering.tiling import tile
from .single import StickSlipCrawlerEnv
from .state import CrawlerState
from .vector import StickSlipCrawlerVectorEnv

__all__ = [
    "CrawlerState",
    "StickSlipCrawlerEnv",
    "StickSlipCrawlerMOEnv",
    "StickSlipCrawlerMOVectorEnv",
    "StickSlipCrawlerVectorEnv",
    "tile",
]
