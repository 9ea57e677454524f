"""Words that user-facing text does not use, and what to write instead (docs/glossary.md).

Checked are the docs, and the docstrings, messages and page texts of every package and benchmark.
"""

import io
import re
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Regular expression of whole words, in any case -> what to write instead.
BANNED = {
    r"tells?|told|telling": "report, log, return, publish or print",
    r"anew": "again, or a verb with re-, such as restart",
    r"(?:is|are|was|were|be|been|not) looked|looks? (?:whether|for|at|from)": "inspect, check",
    r"(?:an?|the|last|each|every|another|one|two|first) looks?": "an observation",
    r"doubt(?:s|ed|ful)?": "a warning, ambiguous or unverified",
    r"guess(?:es|ed|ing)?": "an assumption, assume",
    r"wish(?:es|ed)?": "a preference or soft constraint",
    r"mouths?|bores?": "the opening of a terminal",
    r"let(?:s|ting)? go": "release or detach",
    r"(?:hands|handed|handing|to hand) in": "pass",
    r"comes? (?:again|back)": "respawns or restarts",
    r"(?:is|are|was|were) away": "is not running",
    r"st(?:and|ands|anding|ood) still": "is stopped",
    r"set(?:s|ting)? aside": "skip (the response is `set_aside`)",
    r"put(?:s|ting)? off": "defer",
    r"pass(?:es|ed)? over": "skip",
    r"somebody|nobody|whoever": "the one who acts: an operator, a client, a node",
    r"watch(?:es|ed|ing)? over": "supervise",
    r"nonsense|senseless|makes? no sense": "an invalid goal or a usage error",
    r"(?:the|of|more|many) tries": "attempts",
    r"patience": "the reconnect timeout",
    r"obey(?:s|ed|ing)?": "apply commands",
    r"oversight": "supervision",
    r"leads? away": "leave",
    r"seen at": "located at",
    r"stor(?:y|ies)": "the run log or report",
    r"(?:a|the|is|are) folds?|folded": "compute (a state), lift (a behavior), collapse (a drawing)",
    r"settl(?:e|es|ed|ing)": "verify",
    r"proving": "the pull test",
    r"ribs?": "cross-section profiles",
    r"for ever": "forever",
}

# Values that the production database keeps, which its readers compare.
STORED = {"set aside"}

NO_PROSE = re.compile(
    r"^<!-- drawn by .*?^<!-- end of what is drawn -->"  # written from the code
    r"|^(?P<fence>`{3,}|~{3,}).*?^(?P=fence)"
    r"|<!--.*?-->"
    r"|(?P<ticks>`+).+?(?P=ticks)"
    r"|\]\([^)\s]*\)"
    r"|\"[^\"\n]*(?:\n[^\"\n]+)?\"",  # a quotation, of program output for example
    re.MULTILINE | re.DOTALL,
)


def blank(match):
    """Return the matched text with every character but its line ends replaced by a dot."""
    return re.sub(r"[^\n]", ".", match[0])


def markdown_prose(text):
    """Blank code, generated parts, link targets and quotations; lines keep their numbers."""
    return NO_PROSE.sub(blank, text)


CODE = re.compile(r"(?P<ticks>`+).+?(?P=ticks)|\{[^{}]*\}", re.DOTALL)
LAYOUT = {tokenize.NL, tokenize.COMMENT}


def python_prose(text):
    """Blank everything but strings of several words, with what they quote as code or fill in.

    Strings that Python joins stand with nothing but blanks between them.
    """
    lines = [re.sub(r"[^\n]", ".", line) for line in text.splitlines(keepends=True)]
    joined_from = None
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.STRING:
            if joined_from:
                put(lines, joined_from, re.sub(r"[^\n]", " ", between(text, joined_from, token)))
            put(lines, token.start, CODE.sub(blank, words_of(token.string)))
            joined_from = token.end
        elif token.type not in LAYOUT:
            joined_from = None
    return "".join(lines)


def words_of(literal):
    """Return a string without its quotes; blank it if it is raw, a single word, or stored."""
    prefix, quotes, words = re.fullmatch(
        r"(\w*)(\"{3}|'{3}|[\"'])(.*)\2", literal, re.DOTALL
    ).groups()
    is_name = not re.search(r"\w\s|\s\w", words) or words in STORED
    if "r" in prefix.lower() or is_name:
        return re.sub(r"[^\n]", ".", literal)
    return " " * len(prefix + quotes) + words + " " * len(quotes)


def between(text, start, token):
    """Return the text from a place (line from 1, column) to a token."""
    lines = text.splitlines(keepends=True)[start[0] - 1 : token.start[0]]
    lines[-1] = lines[-1][: token.start[1]]
    lines[0] = lines[0][start[1] :]
    return "".join(lines)


def put(lines, start, text):
    """Write text over lines from a place (line from 1, column) on."""
    for number, part in enumerate(text.splitlines(keepends=True)):
        column = start[1] if number == 0 else 0
        line = lines[start[0] - 1 + number]
        lines[start[0] - 1 + number] = line[:column] + part + line[column + len(part) :]


def unreleased(text):
    """Return a changelog's prose up to its first release, whose words are history."""
    return markdown_prose(re.split(r"^## \[\d", text, maxsplit=1, flags=re.MULTILINE)[0])


def sources():
    """Yield each checked file with the function that returns its prose."""
    yield ROOT / "CHANGELOG.md", unreleased
    for pattern in ("README.md", "CONTRIBUTING.md", "docs/**/*.md", "src/**/README.md"):
        for path in sorted(ROOT.glob(pattern)):
            if path != ROOT / "docs/reference/faults.md":  # written from faults.yaml
                yield path, markdown_prose
    for path in sorted([*ROOT.glob("src/**/src/**/*.py"), *ROOT.glob("benchmarks/**/*.py")]):
        if "test" not in path.relative_to(ROOT).parts:
            yield path, python_prose
    for pattern in (
        *("src/**/src/**/*.css", "src/**/src/**/*.html", "src/**/src/**/*.js"),
        *("src/**/src/**/*.vue", "src/**/launch/*.launch", "src/**/nodes/*"),
    ):  # whose few names are no banned words
        for path in filter(Path.is_file, sorted(ROOT.glob(pattern))):
            if "vendor" not in path.parts:  # written by others
                yield path, str


def findings(name, prose):
    """Return a line for each banned word of a text: file, line, word, replacement."""
    found = [
        (prose.count("\n", 0, match.start()) + 1, " ".join(match[0].split()), instead)
        for words, instead in BANNED.items()
        for match in re.finditer(rf"\b(?:{words})\b".replace(" ", r"\s+"), prose, re.IGNORECASE)
    ]
    return [f"{name}:{line}: '{word}': write {instead}" for line, word, instead in sorted(found)]


@pytest.mark.parametrize(
    ("path", "prose_of"), [pytest.param(*s, id=str(s[0].relative_to(ROOT))) for s in sources()]
)
def test_texts_have_no_banned_words(path, prose_of):
    found = findings(path.relative_to(ROOT), prose_of(path.read_text()))
    assert not found, "\n" + "\n".join(found)


def test_a_banned_word_is_reported_with_its_line_and_replacement():
    assert findings("a.md", markdown_prose("# A\n\nThe node is let\ngo. It is told.\n")) == [
        "a.md:3: 'let go': write release or detach",
        "a.md:4: 'told': write report, log, return, publish or print",
    ]


def test_strings_of_python_are_prose_and_names_are_not():
    text = 'tell = "tell"\nraise Error(\n    "it is let "  # tell\n    f"go {tell} `tell`"\n)\n'
    assert findings("a.py", python_prose(text)) == ["a.py:3: 'let go': write release or detach"]
    assert findings("a.py", python_prose('state = "set aside"\n')) == []
    assert len(findings("a.py", python_prose('state = "is set aside"\n'))) == 1


@pytest.mark.parametrize(
    "text",
    ["`tell`", "``a`\ntell``", "```sh\ntell\n```", '"I tell"', "[a](tell.md)", "<!-- tell -->"],
)
def test_code_quotations_and_links_are_not_prose(text):
    assert findings("a.md", markdown_prose(f"{text}\n")) == []
    assert len(findings("a.md", markdown_prose(f"{text} I tell.\n"))) == 1
