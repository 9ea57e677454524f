#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from cell_behaviors.clean_up_sm import CleanUpSM
from cell_states.choose_state import ChooseState
from cell_states.count_state import CountState
from cell_states.report_state import ReportState
from flexbe_states.wait_state import WaitState
from golden_behaviors.place_connector_sm import PlaceConnectorSM
from other_states.pause_state import PauseState as other_states__PauseState
from remodel_states.count_attempts_state import CountAttemptsState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class WireTaskSM(Behavior):
    '''
    The state chart Wire Task.
    '''


    def __init__(self):
        super(WireTaskSM, self).__init__()
        self.name = 'Wire Task'

        # parameters of this behavior

        # references to used behaviors
        self.add_behavior(CleanUpSM, 'Clean')
        self.add_behavior(PlaceConnectorSM, 'Place/run')

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:1030 y:40, x:1030 y:140
        _state_machine = OperatableStateMachine(outcomes=['wire placed', 'given up'], input_keys=['wire', 'tries'], output_keys=['tries', 'reason'])
        _state_machine.userdata.wire = '007'
        _state_machine.userdata.tries = 0
        _state_machine.userdata.reason = None
        _state_machine.userdata.place_attempts = 0

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        # x:280 y:40, x:280 y:140, x:280 y:240, x:280 y:240
        _sm_place_0 = ConcurrencyContainer(outcomes=['finished', 'failed', 'timed_out'], input_keys=['component_id', 'cable_id'], output_keys=['error_code', 'error_message'], conditions=[
                                        ('finished', [('run', 'finished')]),
                                        ('failed', [('run', 'failed')]),
                                        ('timed_out', [('timer', 'done')])
                                        ])

        with _sm_place_0:
            # x:30 y:40
            OperatableStateMachine.add('run',
                                        self.use_behavior(PlaceConnectorSM, 'Place/run'),
                                        transitions={'finished': 'finished', 'failed': 'failed'},
                                        autonomy={'finished': Autonomy.Inherit, 'failed': Autonomy.Inherit},
                                        remapping={'component_id': 'component_id', 'cable_id': 'cable_id', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:30 y:140
            OperatableStateMachine.add('timer',
                                        WaitState(wait_time=300.0),
                                        transitions={'done': 'timed_out'},
                                        autonomy={'done': Autonomy.Off})


        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Choose',
                                        ChooseState(outcomes=['go_on', 'stop'], hint='Don\x27t force it \x28def and \x23 are fine\x29'),
                                        transitions={'go_on': 'Count', 'stop': 'Say'},
                                        autonomy={'go_on': Autonomy.Low, 'stop': Autonomy.Off})

            # x:430 y:140
            OperatableStateMachine.add('Clean',
                                        self.use_behavior(CleanUpSM, 'Clean', default_keys=['thoroughness'], parameters={'speed': 0.25}),
                                        transitions={'cleaned': 'wire placed', 'failed': 'given up'},
                                        autonomy={'cleaned': Autonomy.Inherit, 'failed': Autonomy.Inherit},
                                        remapping={'cable_id': 'wire', 'left_over': 'clean_left_over'})

            # x:230 y:40
            OperatableStateMachine.add('Count',
                                        CountState(),
                                        transitions={'done': 'Place_attempts'},
                                        autonomy={'done': Autonomy.Off},
                                        remapping={'number': 'tries'})

            # x:830 y:40
            OperatableStateMachine.add('Pause',
                                        other_states__PauseState(duration_s=2),
                                        transitions={'done': 'Place_attempts'},
                                        autonomy={'done': Autonomy.Off})

            # x:680 y:40
            OperatableStateMachine.add('Place',
                                        _sm_place_0,
                                        transitions={'finished': 'Clean', 'failed': 'Pause', 'timed_out': 'Pause'},
                                        autonomy={'finished': Autonomy.Inherit, 'failed': Autonomy.Inherit, 'timed_out': Autonomy.Inherit},
                                        remapping={'component_id': 'wire', 'cable_id': 'wire', 'error_code': 'place_error_code', 'error_message': 'reason'})

            # x:430 y:40
            OperatableStateMachine.add('Place_attempts',
                                        CountAttemptsState(attempts=2),
                                        transitions={'counted': 'Place', 'exhausted': 'Say'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Off},
                                        remapping={'attempt': 'place_attempts'})

            # x:230 y:140
            OperatableStateMachine.add('Say',
                                        ReportState(text='given up', colors=['red', 'white'], options={'loud': True, 'to': None}),
                                        transitions={'reported': 'Clean'},
                                        autonomy={'reported': Autonomy.Off},
                                        remapping={'value': 'wire'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
