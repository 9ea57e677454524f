"""Words that user-facing text does not use, and what to write instead (docs/glossary.md).

Checked are the docs, and the docstrings, messages and page texts of every package and benchmark.
"""

import ast
import re
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

ANY_BANNED = re.compile(
    r"\b(?:{})\b".format(
        "|".join(f"(?P<rule_{n}>{words})".replace(" ", r"\s+") for n, words in enumerate(BANNED))
    ),
    re.IGNORECASE,
)

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
    return [(1, NO_PROSE.sub(blank, text))]


CODE = re.compile(r"(?P<ticks>`+).+?(?P=ticks)", re.DOTALL)


def python_prose(text):
    """Return the strings of several words with their lines, without what they quote as code."""
    strings = [(node.lineno, text_of(node)) for node in outermost_strings(ast.parse(text))]
    return [
        (line, CODE.sub(blank, words))
        for line, words in strings
        if re.search(r"\w\s|\s\w", words) and words not in STORED
    ]


def plain(text):
    """Return a text as it is."""
    return [(1, text)]


def outermost_strings(tree):
    """Yield the strings of a program; Python has joined those that follow each other."""
    if isinstance(tree, ast.JoinedStr) or isinstance(getattr(tree, "value", None), str):
        yield tree
    else:
        for node in ast.iter_child_nodes(tree):
            yield from outermost_strings(node)


def text_of(node):
    """Return the words of a string; a dot stands for each value that is filled in."""
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) for part in node.values)
    return node.value if isinstance(node, ast.Constant) else "."


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
                yield path, plain


def findings(name, prose):
    """Return a line for each banned word of a text: file, line, word, replacement."""
    found = [
        (first + text.count("\n", 0, match.start()), " ".join(match[0].split()), match.lastgroup)
        for first, text in prose
        for match in ANY_BANNED.finditer(text)
    ]
    instead = {f"rule_{number}": text for number, text in enumerate(BANNED.values())}
    return [f"{name}:{line}: '{word}': write {instead[rule]}" for line, word, rule in sorted(found)]


def test_texts_have_no_banned_words():
    found = [
        finding
        for path, prose_of in sources()
        for finding in findings(path.relative_to(ROOT), prose_of(path.read_text()))
    ]
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
