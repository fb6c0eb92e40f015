"""Gymnasium environments of the crawler."""

from .crawler import StickSlipCrawlerEnv
from .state import CrawlerState
from .tiling import tile
from .vector import StickSlipCrawlerVectorEnv

__all__ = ["CrawlerState", "StickSlipCrawlerEnv", "StickSlipCrawlerVectorEnv", "tile"]
