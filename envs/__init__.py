"""Gymnasium environments of the crawler."""

from .multi_objective import StickSlipCrawlerMOEnv, StickSlipCrawlerMOVectorEnv
from .recording import RecordVectorVideo, RecordVideo
from .rendering.tiling import tile
from .single import StickSlipCrawlerEnv
from .state import CrawlerState
from .vector import StickSlipCrawlerVectorEnv

__all__ = [
    "CrawlerState",
    "RecordVectorVideo",
    "RecordVideo",
    "StickSlipCrawlerEnv",
    "StickSlipCrawlerMOEnv",
    "StickSlipCrawlerMOVectorEnv",
    "StickSlipCrawlerVectorEnv",
    "tile",
]
