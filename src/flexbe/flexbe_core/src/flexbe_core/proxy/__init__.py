"""What states use to talk to ROS.

Connections are shared by all proxies of a process and live as long as it: the first proxy that
names a topic makes the connection, with its type and settings.
"""

from flexbe_core.proxy.proxy_action_client import ProxyActionClient
from flexbe_core.proxy.proxy_publisher import ProxyPublisher
from flexbe_core.proxy.proxy_service_caller import ProxyServiceCaller
from flexbe_core.proxy.proxy_subscriber_cached import ProxySubscriberCached
from flexbe_core.proxy.proxy_transform_listener import ProxyTransformListener

__all__ = [
    "ProxyActionClient",
    "ProxyPublisher",
    "ProxyServiceCaller",
    "ProxySubscriberCached",
    "ProxyTransformListener",
]
