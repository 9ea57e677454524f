"""Each tutorial runs, command by command from its own text, and prints what the text shows.

The form of a tutorial (docs/tutorials/README.md):

- A block ```console holds commands behind `$ `, continued behind `> `, each followed by what it
  prints. Blocks without a title share one shell. A command there must end with exit code 0.
- A block with a title, such as "Terminal 2: the cell", is a terminal of its own. Its last command
  keeps running; the tutorial goes on when it has printed what the block shows.
- Of the output shown, `...` as a line stands for any lines, and within a line for any text. A
  command without output shown may print anything.
- A block of another language with a title is a file of that name.
"""

import contextlib
import os
import queue
import re
import signal
import socket
import subprocess
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

TUTORIALS = Path(__file__).parents[1] / "docs/tutorials"
PAGES = sorted(page for page in TUTORIALS.glob("*.md") if page.name != "README.md")
# Other pages in the same form.
OTHERS = [TUTORIALS.parent / f"real-cell/{name}.md" for name in ("launch", "limits")]

# They place a wire in the simulated cell, and build a package.
SLOW = ("1-first-wire", "3-your-ability")

# [s] Wall time: of a command, or until one that keeps running has printed what is shown, and until
# it has ended. The machine may be busy.
LIMIT_S, END_S = 240.0, 30.0
CONSOLE_PORT = "8765"

BLOCK = re.compile(
    r"^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
COLOURS = re.compile(r"\x1b(?:\[[0-9;?]*[A-Za-z]|\][^\x07]*\x07)")
ENDED = "tutorial-command-ended"


@dataclass(frozen=True)
class Command:
    """A command, and the lines that the text shows below it."""

    text: str
    shown: tuple[str, ...]


def commands(block):
    """Return the commands of a console block with the output shown of each."""
    found = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append([line[2:], []])
        elif line.startswith("> ") and found and not found[-1][1]:
            found[-1][0] += "\n" + line[2:]
        elif line.strip():
            assert found, f"output without a command: {line!r}"
            found[-1][1].append(line.strip())
    return [Command(text, tuple(shown)) for text, shown in found]


def pattern(shown):
    """Return the regular expression of the output shown."""
    lines = (
        r"(?:[^\n]*\n)*?" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*") + "\n"
        for line in shown
    )
    return re.compile("".join(lines))


def plain(output):
    """Return an output without colours, blank lines and margins."""
    lines = (line.strip() for line in COLOURS.sub("", output).replace("\r", "\n").splitlines())
    return "".join(f"{line}\n" for line in lines if line)


class Shell:
    """A terminal: a bash with what it has printed."""

    def __init__(self, folder, environment):
        self._is_shared = True
        self._process = subprocess.Popen(
            ["bash", "--noprofile", "--norc"],
            cwd=folder,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )
        self._lines = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put(None)

    def run(self, command):
        """Run a command to its end, and check exit code and output."""
        self._write(f'{{ {command.text}\n}} </dev/null; echo "{ENDED} $?"\n')
        output, deadline = "", time.monotonic() + LIMIT_S
        while (end := re.search(rf"{ENDED} (\d+)\n", output)) is None:
            output += self._next(command, output, deadline)
        output = plain(output[: end.start()])
        assert end[1] == "0", f"exit code {end[1]} of: {command.text}\n{output}"
        if command.shown:
            assert pattern(command.shown).fullmatch(output), differs(command, output)

    def start(self, command):
        """Start a command that keeps running; return when it has printed what is shown."""
        self._is_shared = False
        self._write(f"exec {command.text} </dev/null\n")
        output, deadline = "", time.monotonic() + LIMIT_S
        while not pattern(command.shown).match(plain(output)):
            output += self._next(command, output, deadline)

    def _write(self, line):
        self._process.stdin.write(line)
        self._process.stdin.flush()

    def _next(self, command, output, deadline):
        try:
            line = self._lines.get(timeout=max(0.0, deadline - time.monotonic()))
        except queue.Empty:
            pytest.fail(f"not done in {LIMIT_S:g} s. {differs(command, plain(output))}")
        if line is None:
            pytest.fail(f"the terminal has ended. {differs(command, plain(output))}")
        return line

    def end(self):
        """End what runs in the terminal: Ctrl+C, and after a while more than that.

        What a shell has started in the background ignores Ctrl+C.
        """
        first = () if self._is_shared else (signal.SIGINT,)
        for number in (*first, signal.SIGTERM, signal.SIGKILL):
            # Its session's own group: this process leads it until it has been waited for.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.stdin.close()
                self._process.wait(END_S)
                break
        self._reader.join(END_S)
        self._process.stdout.close()


def differs(command, output):
    """Return the message of an output that is not what is shown."""
    shown = "\n".join(command.shown)
    return f"Shown below `{command.text}`:\n{shown}\nbut it printed:\n{output}"


def free_port():
    with socket.socket() as opened:
        opened.bind(("127.0.0.1", 0))
        return str(opened.getsockname()[1])


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(p, id=p.stem, marks=[pytest.mark.slow] if p.stem in SLOW else [])
        for p in (*PAGES, *OTHERS)
    ],
)
def test_every_command_prints_what_the_tutorial_shows(page, tmp_path):
    home, folder = tmp_path / "home", tmp_path / "home/tutorial"
    folder.mkdir(parents=True)
    environment = {
        **{name: value for name, value in os.environ.items() if name != "DISPLAY"},
        **{"HOME": str(home), "ROS_HOME": str(home / ".ros"), "ROS_HOSTNAME": "127.0.0.1"},
        "ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}",
        "PYTHONUNBUFFERED": "1",
    }
    text = page.read_text().replace(CONSOLE_PORT, free_port())
    with contextlib.ExitStack() as terminals:

        def terminal():
            shell = Shell(folder, environment)
            terminals.callback(shell.end)
            return shell

        own = terminal()
        for block in BLOCK.finditer(text):
            if block["language"] != "console":
                if block["title"]:
                    file = folder / block["title"]
                    file.parent.mkdir(parents=True, exist_ok=True)
                    file.write_text(block["text"])
                continue
            *before, last = commands(block["text"])
            shell = terminal() if block["title"] else own
            for command in before:
                shell.run(command)
            (shell.start if block["title"] else shell.run)(last)


def test_the_page_of_the_tutorials_lists_each():
    listed = re.findall(r"\]\((\d[\w-]*\.md)\)", (TUTORIALS / "README.md").read_text())
    assert listed == [page.name for page in PAGES]
