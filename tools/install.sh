#!/usr/bin/env bash
# Build the workspace apart from devel/, and install it with its Python environment. Usage: install.sh PREFIX
set -euo pipefail
cd "$(dirname "$0")/.."

log=build/install.log
mkdir -p build/install
echo "install: catkin_make install into $1; the first time takes a few minutes (log: $log)"
: >"$log"
tools/progress.py install "$log" catkin_make --no-color --build build/install "-DCATKIN_DEVEL_PREFIX=$PWD/build/install/devel" \
  -DCATKIN_ENABLE_TESTING=OFF "-DPYTHON_EXECUTABLE=$PWD/.venv/bin/python3" "-DCMAKE_INSTALL_PREFIX=$1" install
echo "install: done in $SECONDS s, $(du -sh "$1" | cut -f1)"
