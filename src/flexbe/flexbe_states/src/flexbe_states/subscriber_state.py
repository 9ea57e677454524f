"""Receive a message."""

import rosgraph
import rospy
from roslib.message import get_message_class

from flexbe_core import EventState, Logger
from flexbe_core.proxy import ProxySubscriberCached


class SubscriberState(EventState):
    """Take the last message of a topic, of any type.

    -- topic     string  Topic to listen to.
    -- blocking  bool    Wait for a message if there is none.
    -- clear     bool    On entry, drop messages that arrived before.

    #> message  object  The message; None if there is none, and blocking is false or the topic is
                        unavailable.

    <= received     A message was taken, or there is none and blocking is false.
    <= unavailable  The topic is not advertised.

    """

    def __init__(self, topic, blocking=True, clear=False):
        super().__init__(outcomes=["received", "unavailable"], output_keys=["message"])
        self._topic = topic
        self._blocking = blocking
        self._clear = clear
        self._sub = ProxySubscriberCached()
        self._connected = self._connect()
        self._received = False

    def on_enter(self, userdata):
        """Subscribe, if that was not possible before."""
        self._received = False
        self._connected = self._connected or self._connect()
        if not self._connected:
            Logger.logwarn("%s: topic %s is not advertised", self.name, self._topic)
        elif self._clear:
            self._sub.remove_last_msg(self._topic)

    def execute(self, userdata):
        """Take the message, once there is one."""
        if self._received:
            return "received"
        if not self._connected:
            userdata.message = None
            return "unavailable"
        if not self._sub.has_msg(self._topic) and self._blocking:
            return None
        userdata.message = self._sub.get_last_msg(self._topic)
        self._sub.remove_last_msg(self._topic)
        self._received = True
        return "received"

    def _connect(self):
        """Subscribe with the type that the master knows; return whether it knows one."""
        types = dict(rosgraph.Master(rospy.get_name()).getTopicTypes())
        message_type = types.get(rospy.resolve_name(self._topic))
        message_class = get_message_class(message_type) if message_type else None
        if message_class is None:
            return False
        self._sub.subscribe(self._topic, message_class)
        return True
