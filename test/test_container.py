"""The container image is made from files that exist, by the scripts of `make build`."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
STEPS = [
    line.split()
    for line in (ROOT / "Containerfile").read_text().splitlines()
    if line and not line.startswith("#")
]


def sources_of(script):
    """Return the files of the repository that a script reads before all of it is copied."""
    return set(
        re.findall(r"\b(tools/[\w.-]+|requirements[\w-]*\.txt)", (ROOT / script).read_text())
    )


def test_what_the_setup_reads_is_copied_before_it_runs():
    begun = STEPS.index(["RUN", "tools/setup.sh"])
    copied = {name for words in STEPS[:begun] if words[0] == "COPY" for name in words[1:-1]}
    assert all((ROOT / name).is_file() for name in copied)
    assert copied == {"tools/setup.sh", *sources_of("tools/setup.sh")}


def test_the_image_is_of_the_system_that_the_setup_accepts():
    assert STEPS[0] == ["FROM", "debian:12"]
    assert 'VERSION_ID="12"' in (ROOT / "tools/setup.sh").read_text()


def test_scripts_of_the_image_can_be_run_and_nothing_built_is_copied():
    run = {word for words in STEPS for word in re.findall(r"tools/\w+\.sh", " ".join(words))}
    assert run == {"tools/setup.sh", "tools/build.sh", "tools/in_workspace.sh"}
    assert all((ROOT / name).stat().st_mode & 0o100 for name in run)
    ignored = (ROOT / ".dockerignore").read_text().split()
    assert {".git", ".venv", "build", "devel", "install", "out"} <= set(ignored)
