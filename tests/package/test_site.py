"""The site, built as `make docs` builds it: no warning, every public name, nothing that needs a network."""

import re
import runpy
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MARK = re.compile(r"^<!-- public names: ([\w.]+) -->$", re.MULTILINE)
PICTURES = {"train": 4, "benchmark": 2, "analyse": 4}  # with the one above a tutorial, if it has one

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "--builder", "html", "--nitpicky", "--fail-on-warning", "--quiet"]
    subprocess.run([*command, ROOT / "docs", folder], check=True, timeout=1500)
    return folder


def test_the_reference_has_every_public_name(site):
    from sphinx.util.inventory import InventoryFile

    inventory = InventoryFile.loads((site / "objects.inv").read_bytes(), uri="")
    known = {name for kind in inventory.data if kind.startswith("py:") for name in inventory.data[kind]}
    for page in sorted(ROOT.glob("docs/reference/*.md")):
        for package in MARK.findall(page.read_text(encoding="utf-8")):
            public = {name for name in import_module(package).__all__ if not name.startswith("__")}
            assert {f"{package}.{name}" for name in public} <= known


@pytest.mark.parametrize("name", PICTURES)
def test_a_tutorial_has_its_pictures(site, name):
    page = (site / "tutorials" / f"{name}.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<img [^>]*src="\.\./_images/', page)) == PICTURES[name]


def test_no_page_asks_the_network(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 40
    for page in pages:
        assert not re.search(r'<(?:script|img|link)[^>]+(?:src|href)="(?:https?:)?//', page.read_text(encoding="utf-8"))


def test_formulas_are_drawn(site):
    page = (site / "environment.html").read_text(encoding="utf-8")
    assert page.count("<math ") > 5
    assert "<munderover>" not in page  # the index of an accented letter is beside it


def test_symbols_have_subscripts_and_code_is_as_it_is_typed(site):
    page = (site / "environment.html").read_text(encoding="utf-8")
    assert "z<sub>c</sub> = P<sub>max</sub> A<sub>0</sub> / k<sub>1</sub>" in page
    materials = (site / "materials.html").read_text(encoding="utf-8")
    assert re.search(r"<h1>.* k<sub>1</sub>, k<sub>3</sub>, A<sub>0</sub>", materials)
    for each in site.glob("*.html"):
        text = each.read_text(encoding="utf-8").partition("<article")[2].partition("</article>")[0]
        running = re.sub(r"<(pre|code|math|strong|dt)\b.*?</\1>", "", text, flags=re.DOTALL)
        assert not re.search(r">[^<]*\b[zt]_c\b", running), each.name


def test_the_environment_s_page_has_its_docstring():
    refreshed = runpy.run_path(str(ROOT / "docs" / "environment_page.py"))["refreshed"]
    page = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")
    assert refreshed(page) == page, "`make docs` renews it"


def test_the_citation_is_valid():
    from cffconvert.cli.create_citation import create_citation

    citation = create_citation(str(ROOT / "CITATION.cff"), None)
    citation.validate()
    assert "title = {stickslip" in citation.as_bibtex()
