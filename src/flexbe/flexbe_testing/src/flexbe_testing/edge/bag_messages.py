"""Messages for tests, out of a bag."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import rosbag

from flexbe_testing.errors import CaseError


class BagMessages:
    """The messages of a bag, each topic in the order of recording."""

    def __init__(self, file: Path | None) -> None:
        """Read from `file`; None if the test case has no bag."""
        self._file = file
        self._topics: dict[str, Iterator[Any]] = {}

    def next_of(self, topic: str) -> Any:  # noqa: ANN401 - any type of message
        """Return the next message of a topic.

        Raises:
            CaseError: if there is no bag, or no further message.
        """
        if self._file is None:
            raise CaseError(f"value !{topic} needs a bag; name one as data")
        if topic not in self._topics:
            self._topics[topic] = self._messages(topic)
        try:
            return next(self._topics[topic])
        except StopIteration:
            text = f"bag {self._file} has no further message of topic {topic!r}"
            raise CaseError(text) from None

    def _messages(self, topic: str) -> Iterator[Any]:
        try:
            with rosbag.Bag(str(self._file)) as bag:
                found = [message for _, message, _ in bag.read_messages(topics=[topic])]
        except (OSError, rosbag.ROSBagException) as error:
            raise CaseError(f"cannot read bag {self._file}: {error}") from error
        return iter(found)
