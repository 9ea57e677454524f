from flexbe_core import EventState


class PrintingState(EventState):
    def execute(self, userdata):
        print "done"  # doctor: python2
        return "done"
