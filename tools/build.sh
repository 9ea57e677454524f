#!/usr/bin/env bash
# Build the catkin workspace with the virtual environment's Python.
set -euo pipefail
cd "$(dirname "$0")/.."

compiler=${CXX:-c++}
if ! command -v "${compiler%% *}" >/dev/null; then
  echo "build: no C++ compiler: $compiler is not found; install it (apt-get install g++), or set CXX" >&2
  exit 1
fi
log=build/build.log
mkdir -p build
[ -e devel/setup.sh ] || echo "build: the first time takes a few minutes"
echo "build: catkin_make (log: $log)"
: >"$log"

make_workspace() { tools/progress.py build "$log" catkin_make --no-color "$@" "-DPYTHON_EXECUTABLE=$PWD/.venv/bin/python3"; }

if [ -e build/.configured_sourced ]; then
  make_workspace
else
  # Configured in a shell that does not know the workspace yet, catkin caches an empty PYTHONPATH for the tests: configure
  # it, which writes setup.sh, and then again.
  make_workspace help
  set +u
  . devel/setup.sh
  set -u
  make_workspace --force-cmake
  touch build/.configured_sourced
fi
echo "build: done in $SECONDS s"
