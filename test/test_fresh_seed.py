"""The seed of random input that a run prints is the one that its tests have drawn from."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

DRAWS = "def test_draws(fresh_seed): open({!r}, 'w').write(str(fresh_seed))\n"


@pytest.mark.parametrize("given", [(), ("--fresh-seed", "1234567")])
def test_workers_draw_from_the_seed_that_is_printed(tmp_path, given):
    shutil.copy(Path(__file__).parents[1] / "conftest.py", tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    drawn = [tmp_path / name for name in ("one", "other")]
    for file in drawn:
        (tmp_path / f"test_{file.name}.py").write_text(DRAWS.format(str(file)))
    words = ("-q", "--numprocesses", "2", "--dist", "loadfile", *given)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    printed = re.search(r"--fresh-seed (\d+)", done.stdout)[1]
    assert [file.read_text() for file in drawn] == [printed] * 2
    assert given in ((), ("--fresh-seed", printed))
