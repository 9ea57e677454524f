#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from remodel_states.place_pin_state import PlacePinState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class TestBehaviorExampleSM(Behavior):
    '''
    The chart that the synthesize command of Deliverable 5.1, chapter 4.2, names: it places one pin, with the state
    of chapter 3.2.
    '''


    def __init__(self):
        super(TestBehaviorExampleSM, self).__init__()
        self.name = 'Test Behavior Example'

        # parameters of this behavior

        # references to used behaviors

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:280 y:40, x:280 y:140
        _state_machine = OperatableStateMachine(outcomes=['finished', 'failed'], input_keys=['placepin_id'], output_keys=['elapsed_time'])
        _state_machine.userdata.placepin_id = None
        _state_machine.userdata.elapsed_time = None

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('PlacePin',
                                        PlacePinState(max_time=30.0, topic='remodel_abilities/placepin'),
                                        transitions={'PlacePin finished normally': 'finished', 'PlacePin takes longer than normal': 'finished', 'failed': 'failed', 'command_error': 'failed'},
                                        autonomy={'PlacePin finished normally': Autonomy.Off, 'PlacePin takes longer than normal': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'placepin_id': 'placepin_id', 'elapsed_time': 'elapsed_time', 'error_code': 'place_pin_error_code', 'error_message': 'place_pin_error_message'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
