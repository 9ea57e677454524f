# The Python that has PyBullet, OpenCV and NiceGUI first: installed nodes start with `env python3`.
_remodel_python="$CATKIN_ENV_HOOK_WORKSPACE/venv/bin"
if [ -x "$_remodel_python/python3" ]; then
  case ":$PATH:" in
    *":$_remodel_python:"*) ;;
    *) export PATH="$_remodel_python:$PATH" ;;
  esac
fi
unset _remodel_python
