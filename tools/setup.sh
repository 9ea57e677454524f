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
  echo "setup: Debian 12 carries ROS 1 Noetic's packages; other systems need another way to get them." >&2
  exit 1
fi

missing=()
while read -r package; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -q '^installed$' || missing+=("$package")
done < tools/apt-packages.txt
if ((${#missing[@]})); then
  sudo=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null || { echo "setup: run as root, or install sudo; needed: ${missing[*]}" >&2; exit 1; }
    sudo=(sudo)
  fi
  echo "setup: installing ${#missing[@]} Debian packages: ${missing[*]}"
  "${sudo[@]}" apt-get update -qq
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi

echo "setup: virtual environment .venv (pybullet, OpenCV, test tools)"
/usr/bin/python3 -m venv --system-site-packages .venv
.venv/bin/pip install -qq --disable-pip-version-check -r requirements.txt -r requirements-dev.txt
touch .venv/.ready
