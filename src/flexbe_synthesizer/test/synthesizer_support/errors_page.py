"""The codes and examples of docs/reference/errors.md, which explains their form."""

import re
from dataclasses import dataclass
from pathlib import Path

PAGE = (Path(__file__).parents[4] / "docs" / "reference" / "errors.md").read_text()


@dataclass(frozen=True)
class Example:
    """The example of a code: files, of which the last is the checked chart, and what it gives.

    Each file comes with its lines, which are marked like those of a diff.
    """

    slug: str
    parts: tuple[tuple[str, tuple[str, ...]], ...]
    messages: tuple[str, ...]

    @property
    def chart(self) -> str:
        """Return the name of the checked chart."""
        return self.parts[-1][0]

    def files(self, mark: str) -> dict[str, str]:
        """Return the files of the wrong example, `-`, or of the mended one, `+`."""
        files = dict(CHARTS)
        for name, lines in self.parts:
            wrong, mended = _side(lines, "-"), _side(lines, "+")
            ours = wrong if mark == "-" else mended
            if name in CHARTS:
                there = next(part for part in (mended, wrong) if CHARTS[name].count(part) == 1)
                files[name] = files[name].replace(there, ours)
            else:
                files[name] = ours
        return files


def _side(lines: tuple[str, ...], mark: str) -> str:
    return "".join(f"{line[1:]}\n" for line in lines if line[:1] in ("", " ", mark))


def _example(diff: str, report: str) -> Example:
    messages = report.replace("\n!   ", " ").replace("! ", "").splitlines()
    file, slug = re.match(r"(.+?):.*?\[([\w-]+)\]", messages[0]).groups()
    if not diff.startswith("@@"):
        diff = f"@@ {file} @@\n{diff}"
    parts = re.findall(r"^@@ (\S+) @@\n(.*?)(?=^@@|\Z)", diff, re.MULTILINE | re.DOTALL)
    return Example(
        slug, tuple((name, tuple(lines.splitlines())) for name, lines in parts), tuple(messages)
    )


# Meaning of each code.
CODES = dict(re.findall(r'^\| <a id="([\w-]+)"></a>\1 \| (.*) \|$', PAGE, re.MULTILINE))
CHARTS = {
    re.match(r"<!-- (\S+) -->", text)[1]: text
    for text in re.findall(r"^```xml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
}
EXAMPLES = tuple(
    _example(*example)
    for block in re.findall(r"^```diff\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    for example in re.findall(r"\n*(.*?)((?:^![^\n]*\n)+)", block, re.MULTILINE | re.DOTALL)
)
