"""Who is connected to a publisher or a subscriber of this process."""

from __future__ import annotations

import rospy


def senders(subscriber: rospy.Subscriber) -> set[str]:
    """Return the names of the nodes from which a subscriber receives.

    The list that rospy keeps is replaced, never changed, so that it needs no lock; a connection
    that is still being made has no name yet. actionlib does the same.
    """
    return {c.callerid_pub for c in subscriber.impl.connections if c.callerid_pub != "unknown"}


def drop_dead(publisher: rospy.Publisher) -> None:
    """Drop a publisher's connections to nodes that have died.

    rospy notices them after a while, or when it writes. A node that has started again under its
    name seems to be connected until then, and what is sent to it is lost.
    """
    publisher.impl.check()


def is_heard(publisher: rospy.Publisher) -> bool:
    """Return whether any node receives what a publisher sends."""
    drop_dead(publisher)
    return bool(publisher.get_num_connections() > 0)


def hears(publisher: rospy.Publisher, node: str) -> bool:
    """Return whether a node receives what a publisher sends."""
    drop_dead(publisher)
    return bool(publisher.impl.has_connection(node))
