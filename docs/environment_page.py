"""Write the docstring of the environment into its page: ``python docs/environment_page.py``."""

import re
from inspect import cleandoc
from pathlib import Path

from stickslip.common.files import write_text
from stickslip.envs import StickSlipCrawlerEnv

PAGE = Path(__file__).parent / "environment.md"
PART = re.compile(r"(?<=<!-- docstring -->\n).*(?=<!-- end -->)", re.DOTALL)


def refreshed(page: str) -> str:
    """The page with the docstring as it is now."""
    text = cleandoc(StickSlipCrawlerEnv.__doc__ or "")
    text = re.sub(r"`docs/(\w+)\.md`", r"[more](\1.md)", text)
    return PART.sub(lambda _: f"\n{text}\n\n", page)


if __name__ == "__main__":
    write_text(PAGE, refreshed(PAGE.read_text(encoding="utf-8")))
