#!/usr/bin/env bash
# Build the catkin workspace with the virtual environment's Python.
set -euo pipefail
cd "$(dirname "$0")/.."

make_workspace() { catkin_make --no-color "$@" "-DPYTHON_EXECUTABLE=$PWD/.venv/bin/python3"; }

mkdir -p build
log=build/build.log
echo "build: catkin_make (log: $log)"
{
  make_workspace
  if [ ! -e build/.configured_sourced ]; then
    # Configured in a shell that does not know the workspace yet, catkin caches an empty PYTHONPATH for the tests.
    (set +u; . devel/setup.sh; make_workspace --force-cmake)
    touch build/.configured_sourced
  fi
} >"$log" 2>&1 || { tail -n 40 "$log" >&2; echo "build: failed; the whole log is in $log" >&2; exit 1; }
