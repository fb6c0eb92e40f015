"""Gymnasium environments of the crawler."""

from .crawler import StickSlipCrawlerEnv

__all__ = ["StickSlipCrawlerEnv"]
