"""Names: what they may look like, what becomes of them in FlexBE, and which one was meant."""

from __future__ import annotations

import difflib
import keyword
import re
import unicodedata
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property, lru_cache

NAME_RULE = (
    "letters, digits, '_', '-', '.' and single blanks, starting with a letter; "
    "the words 'def' and 'class' cannot stand alone in it"
)
LONGEST_BEHAVIOR = 200  # letters; a file's name has 255 bytes, and takes a prefix and a suffix
BEHAVIOR_RULE = (
    f"at most {LONGEST_BEHAVIOR} letters, of which a-z, A-Z, 0-9 and '_' alone name the files and "
    "the class, the first of these a letter"
)
TOPIC_RULE = "a-z, A-Z, 0-9, '_' and single '/' between them, starting with a letter, '/' or '~'"
PREEMPTED = "preempted"  # FlexBE adds this outcome to every state and container itself
EXHAUSTED = "exhausted"  # the event that ext:attempts adds
TIMED_OUT = "timed_out"  # the event that ext:timeout_s adds
FAILED = "failed"  # the event that ext:on_error parts by code
ERROR_CODE = "error_code"  # the output that holds the code
_NAME = re.compile(r"[^\W\d_](?:[\w.-]| (?=[\w.-]))*\Z")
_TOPIC = re.compile(r"(?:~/?|/)?[A-Za-z]\w*(?:/\w+)*\Z", re.ASCII)
_CODE_WORD = re.compile(r"(?:^|\s)(?:def|class)(?:\s|$)")  # the FlexBE App splits code at these
_UNREADABLE = re.compile(r"""['"\\()\[\]{},#=\n\r]""")
_HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_NO_WORD = re.compile(r"\W+", re.ASCII)
_COMPARED = 200  # names that one is compared with, letter by letter
_LONGEST_COMPARED = 100  # letters; a longer name is no slip of the pen
_LISTED = 12  # names shown in a message before it says how many more there are


def is_name(text: str) -> bool:
    """Return whether FlexBE can carry the text as the name of a state, outcome or behavior."""
    return bool(_NAME.match(text)) and not _CODE_WORD.search(text)


def is_behavior_name(text: str) -> bool:
    """Return whether files and a class can have the name of a chart."""
    stem = behavior_class(text).removesuffix("SM")
    return len(text) <= LONGEST_BEHAVIOR and stem[:1].isalpha()


def is_topic_parameter(name: str) -> bool:
    """Return whether the value of a parameter is the name of a topic: `topic`, or `..._topic`."""
    return name == "topic" or name.endswith("_topic")


def is_topic(text: str) -> bool:
    """Return whether a text is the name of a ROS topic or action, relative, global or private."""
    return bool(_TOPIC.match(text))


def is_readable_outcome(text: str) -> bool:
    """Return whether the FlexBE App can read the text as an outcome of a state class."""
    return bool(text) and not _UNREADABLE.search(text)


def is_key(text: str) -> bool:
    """Return whether the text can name userdata: a Python identifier that is not private.

    Python takes an identifier in a form of compatibility for another one: `\ufb01x` for `fix`.
    """
    is_identifier = text.isidentifier() and not keyword.iskeyword(text)
    is_itself = text.isascii() or unicodedata.normalize("NFKC", text) == text
    return is_identifier and is_itself and not text.startswith("_")


def behavior_class(name: str) -> str:
    """Return the class that the FlexBE App gives to a behavior."""
    return re.sub(r"\W", "", name, flags=re.ASCII) + "SM"


def behavior_file(name: str) -> str:
    """Return the file name, without suffix, that the FlexBE App gives to a behavior's manifest."""
    return re.sub(r"\W", "_", name.lower(), flags=re.ASCII)


def behavior_module(name: str) -> str:
    """Return the module that the FlexBE App gives to a behavior."""
    return behavior_file(name) + "_sm"


@lru_cache(maxsize=256)  # the outputs of a state follow each other, and have few names
def snake_case(name: str) -> str:
    """Return the name as a part of a Python identifier: `LocateGearbox 2` -> `locate_gearbox_2`."""
    snake = name.lower()
    if not (name.isascii() and name.isidentifier() and name[1:] == snake[1:]):
        snake = _NO_WORD.sub("_", _HUMP.sub("_", name).lower())
    snake = snake.strip("_")
    return snake if snake[:1].isalpha() else f"state_{snake}".rstrip("_")


def take_unused(wanted: str, taken: Collection[str]) -> str:
    """Return the wanted name, numbered from 2 if it is taken."""
    name, number = wanted, 2
    while name in taken:
        name, number = f"{wanted}_{number}", number + 1
    return name


class Vocabulary(tuple[str, ...]):
    """Many names that are searched for those spelled similarly to another one.

    Comparing each found name with each known one takes too long for thousands of both, so only
    those are compared that differ in a letter or two.
    """

    def spelled_like(self, found: str) -> Collection[str]:
        """Return the names that can be meant by a name in small letters, of few names all."""
        if len(self) <= _COMPARED:
            return self
        near: dict[str, None] = {}
        for part in _parts(found):
            near.update(dict.fromkeys(self._by_part.get(part, ())))
        return near

    @cached_property
    def _by_part(self) -> Mapping[str, Sequence[str]]:
        """Return names by what is left of them without one letter, and by themselves."""
        found: dict[str, list[str]] = {}
        for name in self:
            for part in _parts(name.lower()) if len(name) <= _LONGEST_COMPARED else ():
                names = found.setdefault(part, [])
                if len(names) < _COMPARED:
                    names.append(name)
        return found


def _parts(word: str) -> set[str]:
    return {word, *(word[:index] + word[index + 1 :] for index in range(len(word)))}


def nearest(found: str, known: Iterable[str]) -> tuple[str, ...]:
    """Return the known names that come nearest to the one found, best first; at most three."""
    return _close(found, known, cutoff=0.6)


def misspelt(found: str, known: Iterable[str]) -> str | None:
    """Return the known name that the one found is a misspelling of, None if that is not clear."""
    cutoff = 0.8 if len(found) > 5 else 0.6  # one slip is a large part of a short name
    return next(iter(_close(found, known, cutoff)), None)


def _close(found: str, known: Iterable[str], cutoff: float) -> tuple[str, ...]:
    if len(found) > _LONGEST_COMPARED:
        return ()
    word = found.lower()
    candidates = known.spelled_like(word) if isinstance(known, Vocabulary) else known
    by_lower = {name.lower(): name for name in candidates}
    matches = difflib.get_close_matches(word, by_lower, cutoff=cutoff)
    return tuple(by_lower[name] for name in matches)


def quoted(names: Iterable[str]) -> str:
    """Return the names as `'a', 'b'`, in order, shortened where they are many or long."""
    found = tuple(names)
    if not found:
        return "none"
    listed = ", ".join(f"'{shortened(name)}'" for name in found[:_LISTED])
    return listed if len(found) <= _LISTED else f"{listed} and {len(found) - _LISTED} more"


def shortened(name: str) -> str:
    """Return a name as messages show it."""
    return name if len(name) <= _LONGEST_COMPARED else name[:_LONGEST_COMPARED] + "..."


def allowed(found: str, known: Iterable[str]) -> str:
    """Return the end of a message: the nearest names if any come near, and those allowed."""
    known = known if isinstance(known, Vocabulary) else tuple(known)
    near = nearest(found, known)
    meant = f" Did you mean {' or '.join(f'{name!r}' for name in near)}?" if near else ""
    return f"allowed: {quoted(known)}.{meant}"
