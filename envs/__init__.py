"""Gymnasium environments of the crawler."""

from .crawler import StickSlipCrawlerEnv
from .vector import StickSlipCrawlerVectorEnv

__all__ = ["StickSlipCrawlerEnv", "StickSlipCrawlerVectorEnv"]
