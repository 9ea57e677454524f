"""Every link, anchor and command in the docs exists; every page and picture has its place."""

import os
import re
from functools import cache
from pathlib import Path
from urllib.parse import unquote

import yaml

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    page
    for pattern in ("*.md", "docs/**/*.md", "src/**/README.md")
    for page in ROOT.glob(pattern)
    if page.name != "CHANGELOG.md" and "test" not in page.relative_to(ROOT).parts
)
SITE = ROOT / "mkdocs.yml"

FENCE = re.compile(
    r"^(?P<fence>`{3,})(?P<language>\w*)[^\n]*\n(?P<text>.*?)^(?P=fence)", re.M | re.S
)
CODE = re.compile(r"(`+).+?\1", re.DOTALL)
LINK = re.compile(r"!?\[[^\]]*\]\(<?([^)\s>]+)>?(?: \"[^\"]*\")?\)")
HEADING = re.compile(r"^#{1,6} +(.*?)\s*#*$", re.MULTILINE)
# What a command may begin with, at the start of a line or behind a prompt, `&&`, `|`, `(` or `;`.
STARTS = r"(?:^|\$ |&& |\| |\(|; )"
ROSRUN = re.compile(rf"{STARTS}rosrun (?:--\S+ )*(\w+) (\w+)", re.MULTILINE)
REMODEL = re.compile(rf"{STARTS}remodel (\w+)", re.MULTILINE)
ROSLAUNCH = re.compile(rf"{STARTS}roslaunch (?:-\S+ \S+ )?(\w+) ([\w.]+\.launch)([^\n#`]*)", re.M)
MAKE = re.compile(rf"{STARTS}make ([a-z][a-z-]*)", re.MULTILINE)
SCRIPT = re.compile(r"(?<![\w./-])((?:benchmarks|tools)/[\w./-]+\.(?:py|sh))")
PACKAGES = {
    manifest.parent.name: manifest.parent
    for manifest in ROOT.glob("src/**/package.xml")
    if "test" not in manifest.relative_to(ROOT).parts
}


@cache
def prose(page):
    """Return a page without its blocks and its code."""
    return CODE.sub("", FENCE.sub("", page.read_text()))


@cache
def anchors(page):
    """Return the anchors of a page's headings, as GitHub and the site write them."""
    found = []
    for heading in HEADING.findall(FENCE.sub("", page.read_text())):
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", text).strip().replace(" ", "-")
        found.append(anchor if anchor not in found else f"{anchor}-{found.count(anchor)}")
    return {*found, *re.findall(r"<a (?:id|name)=\"([^\"]+)\"", page.read_text())}


def shell_text(page):
    """Return the commands of a page: its blocks of shell, and its code that begins as one."""
    text = page.read_text()
    blocks = [
        match["text"]
        for match in FENCE.finditer(text)
        if match["language"] in ("sh", "bash", "console")
    ]
    code = [match[0].strip("`") for match in CODE.finditer(FENCE.sub("", text))]
    return "\n".join([*blocks, *code])


def broken_links(page):
    for target in LINK.findall(prose(page)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = unquote(target).partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists():
            yield f"{target}: there is no {os.path.relpath(file, ROOT)}"
        elif anchor and file.suffix == ".md" and anchor not in anchors(file):
            yield f"{target}: no such heading; there are: {', '.join(sorted(anchors(file)))}"


def broken_commands(page):
    text = shell_text(page)
    for package, node in ROSRUN.findall(text):
        folder = PACKAGES.get(package)
        if folder and not (folder / "nodes" / node).is_file():
            yield f"rosrun {package} {node}: no such node in {folder.relative_to(ROOT)}/nodes"
    known = subcommands()
    yield from (
        f"remodel {name}: no such subcommand; there are: {', '.join(known)}"
        for name in REMODEL.findall(text)
        if name not in known and name.islower()
    )
    for package, launch, arguments in ROSLAUNCH.findall(text):
        folder = PACKAGES.get(package)
        if folder is None:
            continue
        file = folder / "launch" / launch
        if not file.is_file():
            yield f"roslaunch {package} {launch}: there is no {file.relative_to(ROOT)}"
            continue
        allowed = re.findall(r"<arg name=\"(\w+)\"(?! value)", file.read_text())
        for name in re.findall(r"\b(\w+):=", arguments):
            if not name.startswith("_") and name not in allowed:
                yield f"{launch} {name}:=: no such argument; there are: {', '.join(allowed)}"
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    yield from (
        f"make {name}: no such target" for name in MAKE.findall(text) if name not in targets
    )
    for script in SCRIPT.findall(text):
        places = (ROOT, page.parent)
        if not any((place / script).is_file() for place in places):
            yield f"{script}: there is no such file"


@cache
def subcommands():
    source = ROOT / "src/remodel_planner/src/remodel_planner/commands/remodel.py"
    return re.findall(r"^    \"([\w-]+)\": \(", source.read_text(), re.MULTILINE)


def test_the_programs_that_the_makefile_runs_are_executable():
    makefile = (ROOT / "Makefile").read_text()
    named = set(re.findall(r"(?:benchmarks|tools)/[\w/]+\.(?:py|sh)", makefile))
    assert len(named) > 20
    assert [name for name in sorted(named) if not os.access(ROOT / name, os.X_OK)] == []


def test_python_in_the_docs_compiles():
    for page in PAGES:
        for match in FENCE.finditer(page.read_text()):
            if match["language"] == "python":
                compile(match["text"], str(page), "exec")


def test_links_anchors_and_commands_exist():
    broken = [
        f"{page.relative_to(ROOT)}: {problem}"
        for page in PAGES
        for problem in (*broken_links(page), *broken_commands(page))
    ]
    assert not broken, "\n" + "\n".join(broken)


def test_every_kind_of_mistake_is_found(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "# Two words\n[a](#two-words) [b](#three) [c](none.md)\n"
        "```sh\nrosrun remodel_planner planer\nremodel imprt x\n"
        "roslaunch remodel_sim cel.launch\nroslaunch remodel_sim cell.launch gu:=true\n"
        "make tea\nbenchmarks/none.py\n```\n"
    )
    assert len([*broken_links(page)]) == 2
    assert len([*broken_commands(page)]) == 6


def test_every_picture_is_shown_by_a_page():
    shown = {
        (page.parent / unquote(link)).resolve()
        for page in PAGES
        for link in LINK.findall(prose(page))
        if ":" not in link
    }
    pictures = {p for kind in ("png", "webp") for p in (ROOT / "docs").rglob(f"*.{kind}")}
    assert len(pictures) > 10
    assert sorted(pictures - shown) == []


def test_each_difference_from_flexbe_has_its_test():
    rows = (ROOT / "docs/compatibility.md").read_text().split("|---|---|---|\n")[1].splitlines()
    named = [re.search(r"\[(test_\w+)\]\(\.\./(.+)\) \|$", row) for row in rows]
    assert len(rows) > 5
    assert all(named), rows
    for name, file in (match.groups() for match in named):
        assert f"def {name}(" in (ROOT / file).read_text(), f"{file} has no {name}"


def site_pages(entries):
    """Yield the files of the site's navigation."""
    for entry in entries:
        for value in entry.values() if isinstance(entry, dict) else [entry]:
            yield from site_pages(value) if isinstance(value, list) else [value]


def test_the_site_has_every_page_of_the_docs_once():
    # The tags of Material's settings are no values of this test.
    loader = type("Loader", (yaml.SafeLoader,), {})
    loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda *_: None)
    navigation = yaml.load(SITE.read_text(), loader)["nav"]
    listed = [*site_pages(navigation)]
    assert sorted(listed) == sorted(set(listed))
    pages = {str(page.relative_to(ROOT / "docs")) for page in ROOT.glob("docs/**/*.md")}
    assert set(listed) == pages
