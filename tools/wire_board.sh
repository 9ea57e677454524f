#!/usr/bin/env bash
# Import a design, and wire it in the simulated cell; the report is in out/NAME.
# Usage: wire_board.sh NAME DESIGN WIRES USE_CASE [argument of order.launch]...; an empty USE_CASE is the default of such designs,
# and a cell:=NAME is also the cell that the design is imported for.
set -euo pipefail
cd "$(dirname "$0")/.."

name=$1 design=$2 wires=$3 use_case=$4 cell=
for argument in "${@:5}"; do
  [[ $argument != cell:=* ]] || cell=${argument#cell:=}
done
out=$PWD/out/$name
rm -rf "$out"
mkdir -p "$out/charts"

# A ROS master of its own, so that another one on this machine is not disturbed.
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
export ROS_MASTER_URI=http://127.0.0.1:$port ROS_IP=127.0.0.1 ROS_LOG_DIR=$out/log
export REMODEL_DATABASE=sqlite:///$out/production.sqlite
export ROS_PACKAGE_PATH=$out/remodel_order_behaviors:$ROS_PACKAGE_PATH

remodel import "$design" --order "$name" ${use_case:+--use-case "$use_case"} ${cell:+--cell "$cell"}

roslaunch -p "$port" remodel_planner order.launch output:="$out" database:="$REMODEL_DATABASE" "${@:5}" >"$out/nodes.log" 2>&1 &
nodes=$!
stop_nodes() {
  kill -INT "$nodes" 2>/dev/null || true
  wait "$nodes" 2>/dev/null || true
}
trap stop_nodes EXIT

echo "cell, synthesizer and engine are starting (log: out/$name/nodes.log)"
remodel run "$name" --wait 90 --wires "$wires" --use-case "$use_case" --output "$out"
