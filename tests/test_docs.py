"""The documents point to what there is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")])
IMAGES = sorted((ROOT / "docs" / "images").iterdir())


def links(page: Path) -> list[str]:
    """Targets of a page's links and pictures within the project."""
    found = re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8"))
    return [one for one in found if "://" not in one]


def anchors(page: Path) -> set[str]:
    """Names of a page's headings as links write them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for link in links(page):
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name}: {link}"
        assert not anchor or anchor in anchors(target), f"{page.name}: {link}"


@pytest.mark.parametrize("picture", IMAGES, ids=lambda picture: picture.name)
def test_each_picture_stands_in_a_page(picture: Path) -> None:
    assert any(f"images/{picture.name}" in page.read_text("utf-8") for page in PAGES)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_scripts_that_a_page_names_are_there(page: Path) -> None:
    for script in re.findall(r"python ((?:examples|benchmarks)/\S+\.py)", page.read_text("utf-8")):
        assert (ROOT / script).exists(), f"{page.name}: {script}"
