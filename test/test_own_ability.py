"""A package that create_ability makes in another workspace builds, and its own test passes."""

import os
import subprocess
import sys

# [s] Wall time of one command; the machine may be busy.
LIMIT_S = 300.0

# What the workspace's nodes find of the new package.
FOUND = """
from remodel_states.serving.ability_messages import message_class
from remodel_states.edge.exported_tables import read_abilities, read_faults
crimp = read_abilities()["CrimpFerrule"]
print(message_class(crimp, "Goal").__slots__, dict(crimp.fake))
print(read_faults().numbers["CRIMP_FERRULE_FAILED"])
"""


def run(folder, *lines):
    """Run lines of shell; return what they print."""
    # Messages for Python alone: the others take most of the time of a build.
    other_languages = "gencpp:geneus:genlisp:gennodejs"
    done = subprocess.run(
        ["bash", "-e", "-c", "\n".join(lines)],
        cwd=folder,
        env={**os.environ, "ROS_LANG_DISABLE": other_languages, "PYTHON": sys.executable},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_new_ability_out_of_tree_keeps_the_contract_at_once(tmp_path):
    (tmp_path / "src").mkdir()
    created = run(tmp_path, "rosrun remodel_states create_ability CrimpFerrule --into src")
    assert "action/CrimpFerrule.action" in created
    run(tmp_path, 'catkin_make --no-color -DPYTHON_EXECUTABLE="$PYTHON"')
    sourced = ". devel/setup.bash"
    found = run(tmp_path, sourced, f"python3 -c '{FOUND}'")
    assert found == "['id', 'target_id', 'force_limit', 'timeout'] {'peak_force': 5.0}\n1000\n"
    ran = run(tmp_path, sourced, "rostest crimp_ferrule crimp_ferrule.test")
    assert "TESTS: 4" in ran
