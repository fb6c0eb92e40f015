"""The pages: their links, where the site has them, and versions."""

import os
import re
import tomllib
from pathlib import Path

import pytest
import yaml

import stickslip

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("reference/*.md"), *DOCS.glob("tutorials/*.py"), *ROOT.glob("*.md")])
SITE = sorted(page for page in PAGES if DOCS in page.parents)


def read(page):
    """A page without its blocks of code."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".py":
        cells = re.findall(r"^# %% \[markdown\]\n((?:#.*\n)+)", text, re.MULTILINE)
        text = re.sub(r"^# ?", "", "\n".join(cells), flags=re.MULTILINE)
    return re.sub(r"^ *```.*?^ *```", "", text, flags=re.DOTALL | re.MULTILINE)


def anchors(page):
    """Of its headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", read(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", read(page)):
        if "://" in link or link == "LINK":
            continue
        file, _, anchor = link.partition("#")
        target = page if not file else (page.parent / file).resolve()
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_no_page_has_two_versions_of_itself(page):
    assert not re.search(r"^(?:<{7}|>{7}) ", page.read_text(encoding="utf-8"), re.MULTILINE)


def in_the_tree(page):
    text = page.read_text(encoding="utf-8")
    for block in re.findall(r"```\{toctree\}\n(.*?)```", text, re.DOTALL):
        for entry in re.sub(r"^:.*$", "", block, flags=re.MULTILINE).split():
            yield (page.parent / entry).resolve()


def test_every_page_has_one_place_in_the_site():
    placed = [*in_the_tree(DOCS / "index.md"), *in_the_tree(DOCS / "reference" / "index.md")]
    assert sorted(placed) == sorted(page.with_suffix("") for page in SITE if page != DOCS / "index.md"), (
        "a page stands in one toctree of docs/index.md"
    )


def public_packages():
    """Those with names in their `__all__`, read and not imported, but for programs."""
    source = ROOT / "src" / "stickslip"
    for file in sorted(Path(folder) / "__init__.py" for folder, _, files in os.walk(source, followlinks=True) if files):
        if not file.exists() or {"commands", "demo"} & set(file.relative_to(source).parts):
            continue
        (listed,) = re.findall(r"^__all__ = \[(.*?)\]", file.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE) or [
            ""
        ]
        if listed.strip():
            yield ".".join(file.parent.relative_to(source.parent).parts)


def test_every_public_package_stands_in_the_reference():
    marks = re.findall(
        r"^<!-- public names: ([\w.]+) -->$",
        "\n".join(page.read_text(encoding="utf-8") for page in sorted(DOCS.glob("reference/*.md"))),
        re.MULTILINE,
    )
    assert sorted(marks) == sorted(public_packages()), "a package's names have a mark in docs/reference"


def test_every_extra_of_users_is_told():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    told = re.findall(r"^\| `(\w+)` \|", (DOCS / "installation.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(told) == sorted(extras.keys() - {"dev", "peers"})


def test_the_version_is_one():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert project["version"] == stickslip.__version__ == citation["version"]
    assert f"## [{stickslip.__version__}] - {citation['date-released']}\n" in changes
