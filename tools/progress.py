#!/usr/bin/python3
"""Run a command, its output into a log, and show how far it is: progress.py NAME LOG COMMAND...

On a terminal one line is rewritten; elsewhere a line is printed now and then. The progress is what
catkin_make prints ("[ 45%]") and, else, the last line. Ends with the command's exit status; when
it fails, the end of the log is printed.
"""

import re
import subprocess
import sys
import time
from pathlib import Path

PERCENT = re.compile(r"^\[ *(\d+)%\] *(.*)")
PLAIN_PERIOD_S = 15.0
SHOWN_OF_LOG = 40


def shown(line: str) -> str:
    """Return what is worth showing of a line, in one line of a terminal."""
    match = PERCENT.match(line)
    return (f"{match[1]} %  {match[2]}" if match else line.strip())[:60]


def run(name: str, log: Path, command: list[str]) -> int:
    """Run the command and show its progress; return its exit status."""
    started = last = time.monotonic()
    terminal = sys.stderr.isatty()
    with (
        log.open("a") as file,
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        ) as process,
    ):
        for line in process.stdout or ():
            file.write(line)
            now = time.monotonic()
            if (
                not line.strip()
                or not (terminal or now - last > PLAIN_PERIOD_S)
                or line.startswith("make[")
            ):
                continue
            last = now
            text = f"{name}: {now - started:.0f} s  {shown(line)}"
            print(
                f"\r\033[K{text}" if terminal else text,
                end="" if terminal else "\n",
                file=sys.stderr,
                flush=True,
            )
    if terminal:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    if process.returncode:
        lines = log.read_text(errors="replace").splitlines()[-SHOWN_OF_LOG:]
        print(*lines, f"{name}: failed; the whole log is in {log}", sep="\n", file=sys.stderr)
    return process.returncode


if __name__ == "__main__":
    sys.exit(run(sys.argv[1], Path(sys.argv[2]), sys.argv[3:]))
