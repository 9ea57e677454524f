#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from flexbe_states.log_state import LogState
from flexbe_states.wait_state import WaitState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class ExampleBehaviorSM(Behavior):
    '''
    The behavior that the command lines of Deliverable 5.1, chapter 5, start: it says hello, waits, and ends.
    '''


    def __init__(self):
        super(ExampleBehaviorSM, self).__init__()
        self.name = 'Example Behavior'

        # parameters of this behavior

        # references to used behaviors

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:430 y:40
        _state_machine = OperatableStateMachine(outcomes=['finished'])

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Say hello',
                                        LogState(text='Hello from the Example Behavior.'),
                                        transitions={'done': 'Wait'},
                                        autonomy={'done': Autonomy.Off})

            # x:230 y:40
            OperatableStateMachine.add('Wait',
                                        WaitState(wait_time=2.0),
                                        transitions={'done': 'finished'},
                                        autonomy={'done': Autonomy.Off})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
