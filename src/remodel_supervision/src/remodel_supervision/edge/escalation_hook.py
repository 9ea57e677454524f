"""Notify persons who are not at the console: a command or a webhook gets each event as JSON.

Events wait in a queue of their own for one thread, so that neither a slow pager nor a dead network
holds up or fails a run.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import queue
import shlex
import shutil
import signal
import subprocess
import threading
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable, Mapping, Sequence
from http.client import HTTPException

from remodel_supervision.errors import HookError

# [s] wall time that one delivery gets; events that may wait.
DELIVERY_S = 10.0
_WAITING = 100

_LOG = logging.getLogger(__name__)
_COMMAND = "command:"
_TEXT_LIMIT = 300

# Delivers a JSON document within a limit [s]; raises HookError if it could not.
Deliver = Callable[[bytes, float], None]
Report = Callable[[str], object]


class EscalationHook:
    """Delivers events, in their order.

    Attributes:
        name: what delivers them, for a person.
    """

    def __init__(
        self, name: str, deliver: Deliver, report: Report, limit_s: float = DELIVERY_S
    ) -> None:
        """Start to deliver.

        Args:
            name: what delivers events.
            deliver: does so.
            report: gets a sentence about each event that was not delivered, from another thread.
            limit_s: [s] wall time that one delivery gets.
        """
        self.name = name
        self._deliver = deliver
        self._report = report
        self._limit_s = limit_s
        self._events: queue.Queue[bytes | None] = queue.Queue(_WAITING)
        self._thread = threading.Thread(target=self._run, name="escalation", daemon=True)
        self._thread.start()

    @classmethod
    def from_option(
        cls,
        option: str,
        report: Report = _LOG.warning,
        limit_s: float = DELIVERY_S,
    ) -> EscalationHook | None:
        """Return the hook of an option; None if it is empty.

        Args:
            option: "command:PROGRAM ARGUMENT..." or a URL of http or https.
            report: see EscalationHook.
            limit_s: [s] wall time that one delivery gets.

        Raises:
            HookError: if it is neither, or there is no such program.
        """
        if not option:
            return None
        if option.startswith(_COMMAND):
            return cls(option, _command(option), report, limit_s)
        with contextlib.suppress(ValueError):  # brackets or a port that no address has
            address = urllib.parse.urlsplit(option)
            has_host = bool(address.hostname) and address.port != 0 and address.username is None
            if address.scheme in ("http", "https") and has_host:
                shown = f"{address.scheme}://{address.hostname}"  # its path is often a secret
                return cls(shown, _webhook(option), report, limit_s)
        raise HookError(
            f"escalation hook {option!r}: expected command:/path/to/program or https://..., "
            "without user and password"
        )

    def notify(self, event: Mapping[str, object]) -> None:
        """Have an event delivered; return at once, and never raise because of its delivery.

        Args:
            event: what JSON can hold.
        """
        try:
            self._events.put_nowait(json.dumps(event).encode())
        except queue.Full:
            self._report(f"{self.name}: {_WAITING} events wait already; one was dropped")
        except (TypeError, ValueError) as error:
            self._report(f"{self.name}: the event is not JSON: {error}")

    def close(self, limit_s: float = DELIVERY_S) -> None:
        """Deliver what waits, within a limit of wall time [s], and end."""
        with contextlib.suppress(queue.Full):
            self._events.put(None, timeout=limit_s)
        self._thread.join(limit_s)

    def _run(self) -> None:
        while (document := self._events.get()) is not None:
            try:
                self._deliver(document, self._limit_s)
            except HookError as error:
                self._report(f"{self.name}: {error}")


def _command(option: str) -> Deliver:
    """Return what runs a program, without a shell, with the document on its standard input."""
    try:
        words = shlex.split(option.removeprefix(_COMMAND))
    except ValueError as error:
        raise HookError(f"escalation hook {option!r}: {error}") from error
    if not words or shutil.which(words[0]) is None:
        raise HookError(f"escalation hook {option!r}: there is no such program that can be run")

    def deliver(document: bytes, limit_s: float) -> None:
        _run_program(words, document, limit_s)

    return deliver


def _run_program(words: Sequence[str], document: bytes, limit_s: float) -> None:
    try:
        process = subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    except OSError as error:
        raise HookError(f"cannot be started: {error}") from error
    with process:
        try:
            _, errors = process.communicate(document, limit_s)
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # with whatever it has started
            raise HookError(f"did not end within {limit_s:g} s and was killed") from None
    if process.returncode:
        said = errors.decode(errors="replace").strip()[-_TEXT_LIMIT:]
        raise HookError(f"ended with code {process.returncode}{': ' if said else ''}{said}")


def _webhook(url: str) -> Deliver:
    """Return what posts the document to a URL."""

    def deliver(document: bytes, limit_s: float) -> None:
        request = urllib.request.Request(
            url, document, {"Content-Type": "application/json"}, method="POST"
        )
        try:
            urllib.request.urlopen(request, timeout=limit_s).close()
        except urllib.error.HTTPError as error:
            error.close()
            raise HookError(f"answered {error.code} {error.reason}") from error
        except (OSError, HTTPException) as error:
            raise HookError(f"cannot be reached: {error}") from error

    return deliver
