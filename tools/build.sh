#!/usr/bin/env bash
# Build the catkin workspace with the virtual environment's Python.
set -euo pipefail
cd "$(dirname "$0")/.."

log=build/build.log
mkdir -p build
echo "build: catkin_make (log: $log)"
: >"$log"

# Bash ignores `set -e` in everything before `||`, functions and subshells included; so only single commands stand there.
fail() { tail -n 40 "$log" >&2; echo "build: failed; the whole log is in $log" >&2; exit 1; }
make_workspace() { catkin_make --no-color "$@" "-DPYTHON_EXECUTABLE=$PWD/.venv/bin/python3" >>"$log" 2>&1 || fail; }

make_workspace
if [ ! -e build/.configured_sourced ]; then
  # Configured in a shell that does not know the workspace yet, catkin caches an empty PYTHONPATH for the tests.
  set +u
  . devel/setup.sh
  set -u
  make_workspace --force-cmake
  touch build/.configured_sourced
fi
