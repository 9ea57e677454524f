"""The states in which every transition asks the operator: a parameter, read without a call.

rospy subscribes to a parameter the first time it is read with a cache, but asks the master each
time for one that is not set. So the cache is read here once it is subscribed.
"""

from __future__ import annotations

import functools

import rospy
from rospy.impl.paramserver import get_param_server_cache

from flexbe_core.ros.topics import BREAKPOINTS_PARAMETER


@functools.cache
def subscribe() -> None:
    """Subscribe to changes of the parameter; the first call is a call to the master."""
    rospy.get_param_cached(BREAKPOINTS_PARAMETER, [])


def current() -> frozenset[str]:
    """Return the paths of the states that are breakpoints."""
    try:
        paths = get_param_server_cache().get(BREAKPOINTS_PARAMETER)
    except KeyError:
        return frozenset()
    return frozenset(map(str, paths)) if isinstance(paths, list) else frozenset()
