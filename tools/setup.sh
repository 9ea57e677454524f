#!/usr/bin/env bash
# Bring a Debian 12 machine to where the workspace builds: Debian's packages, then a virtual environment.
# As root or as a user with sudo. What is there already is left alone; nothing outside .venv/ and apt is touched.
set -euo pipefail
cd "$(dirname "$0")/.."

if [[ $PWD == *[[:space:]]* ]]; then
  echo "setup: catkin and ROS cannot build in a path with blanks; move the workspace out of '$PWD'." >&2
  exit 1
fi

if ! grep -q '^VERSION_ID="12"' /etc/os-release; then
  echo "setup: this workspace is built for Debian 12 (bookworm); found $(. /etc/os-release && echo "$PRETTY_NAME")." >&2
  echo "setup: on other systems run it in a container of Debian 12" >&2
  exit 1
fi

log=build/setup.log
mkdir -p build
: >"$log"

missing=()
while read -r package; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -q '^installed$' || missing+=("$package")
done < tools/apt-packages.txt
if ((${#missing[@]})); then
  sudo=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null || { echo "setup: run as root, or install sudo; needed: ${missing[*]}" >&2; exit 1; }
    sudo=(sudo)
    sudo -v
  fi
  echo "setup: installing ${#missing[@]} Debian packages (log: $log): ${missing[*]}"
  # Before Python is there, which shows the progress.
  "${sudo[@]}" apt-get update -qq
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends python3 >>"$log"
  tools/progress.py setup "$log" "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends "${missing[@]}"
fi

echo "setup: virtual environment .venv: PyBullet, OpenCV, NiceGUI, test tools (log: $log)"
[ -x .venv/bin/pip ] || /usr/bin/python3 -m venv --system-site-packages .venv
tools/progress.py setup "$log" .venv/bin/pip install --disable-pip-version-check -r requirements.txt -r requirements-dev.txt
touch .venv/.ready
echo "setup: done in $SECONDS s"
