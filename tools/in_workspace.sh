#!/usr/bin/env bash
# Run a command with the built workspace: in_workspace.sh COMMAND... The first process of the container.
cd "$(dirname "$0")/.."
export PATH=$PWD/.venv/bin:$PATH
. devel/setup.bash
exec "$@"
