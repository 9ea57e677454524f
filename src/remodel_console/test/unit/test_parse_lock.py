"""Threads of the console parse Python at the same time."""

import subprocess
import sys

THREADS_THAT_PARSE = """
import ast, gc, sys, threading, time
from remodel_console.edge.workspace import lock_parsing

lock_parsing()
gc.set_threshold(500)
gc.callbacks.append(lambda *_: time.sleep(0))  # as a finalizer may: another thread goes on
text = "\\n".join(f"a{i} = f(b, [c, (d, {{'e': {i}}})])" for i in range(500))
failed = []

def parse():
    try:
        for _ in range(6):
            ast.parse(text)
            ast.literal_eval("[1, (2, 3)]")
    except SystemError as error:
        failed.append(error)

threads = [threading.Thread(target=parse) for _ in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
sys.exit(str(failed[0]) if failed else 0)
"""


def test_threads_parse_at_the_same_time():
    line = [sys.executable, "-c", THREADS_THAT_PARSE]
    ended = subprocess.run(line, capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
