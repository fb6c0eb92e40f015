"""Gymnasium environments of the crawler."""

from .crawler import StickSlipCrawlerEnv
from .tiling import tile
from .vector import StickSlipCrawlerVectorEnv

__all__ = ["StickSlipCrawlerEnv", "StickSlipCrawlerVectorEnv", "tile"]
