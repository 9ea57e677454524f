"""What the site of the documentation has besides docs/: the README, and those of the packages.

MkDocs calls the functions (mkdocs.yml). Links from page to page remain; a link to another file of
the repository becomes its path.
"""

import os
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
LINK = re.compile(r"(?P<image>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")


def _pages() -> dict[Path, str]:
    """Return where on the site each page outside docs/ is."""
    readmes = sorted(path for path in ROOT.glob("src/**/README.md") if "test" not in path.parts)
    return {ROOT / "README.md": "index.md"} | {
        readme: f"packages/{readme.parent.name}.md" for readme in readmes
    }


PAGES = _pages()


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages outside docs/."""
    for path, place in PAGES.items():
        files.append(File.generated(config, place, content=path.read_text(encoding="utf-8")))
    return files


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put those pages into the navigation."""
    config.nav.insert(0, {"Home": "index.md"})
    packages = [place for place in PAGES.values() if place != "index.md"]
    config.nav.append({"Packages": packages})
    return config


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links of the repository into links of the site."""
    place = Path(page.file.src_uri)
    source = next((path for path, at in PAGES.items() if at == str(place)), ROOT / "docs" / place)

    def on_site(match: re.Match[str]) -> str:
        path, _, anchor = match["target"].partition("#")
        if re.match(r"[a-z]+:", match["target"]) or not path:
            return match[0]
        file = (source.parent / path).resolve()
        if file in PAGES:
            target = PAGES[file]
        elif file.is_file() and file.is_relative_to(ROOT / "docs"):
            target = str(file.relative_to(ROOT / "docs"))
        else:
            return f"{match['text']} (`{file.relative_to(ROOT)}`)"
        relative = os.path.relpath(target, place.parent)
        return f"{match['image']}[{match['text']}]({relative}{'#' + anchor if anchor else ''})"

    return LINK.sub(on_site, markdown)
