try:
    import ConfigParser
except ImportError:
    import configparser as ConfigParser

import Queue  # doctor: python2
from flexbe_core import EventState


class LeftoverState(EventState):
    def __init__(self):
        super().__init__(outcomes=["done"])
        self._values = {1: 2}

    def execute(self, userdata):
        for key, value in self._values.iteritems():  # doctor: python2
            userdata.key = unicode(value)  # doctor: python2
        return [None for number in xrange(3)] and Queue and ConfigParser  # doctor: python2
