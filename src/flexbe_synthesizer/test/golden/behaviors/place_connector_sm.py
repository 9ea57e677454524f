#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from cell_states.extract_cable_state import ExtractCableState
from cell_states.fix_cable_state import FixCableState
from cell_states.insert_cable_state import InsertCableState
from cell_states.locate_component_state import LocateComponentState
from flexbe_states.wait_state import WaitState
from remodel_states.count_attempts_state import CountAttemptsState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class PlaceConnectorSM(Behavior):
    '''
    Place a connector as in Figure 3: locate the terminal, insert the cable, fix it.
    After a failed insertion the cable is pulled out and the terminal is located again.
    '''


    def __init__(self):
        super(PlaceConnectorSM, self).__init__()
        self.name = 'Place Connector'

        # parameters of this behavior

        # references to used behaviors

        # Initialization of your own belongs between these tags.
        # [MANUAL_INIT]

        # [/MANUAL_INIT]

        # Behavior comments:



    def create(self):
        # x:1330 y:40, x:1330 y:140
        _state_machine = OperatableStateMachine(outcomes=['finished', 'failed'], input_keys=['component_id', 'cable_id'], output_keys=['error_code', 'error_message'])
        _state_machine.userdata.component_id = None
        _state_machine.userdata.cable_id = None
        _state_machine.userdata.error_code = None
        _state_machine.userdata.error_message = None
        _state_machine.userdata.insert_attempts = 0
        _state_machine.userdata.locate_attempts = 0

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        # x:280 y:40, x:280 y:140, x:280 y:240, x:280 y:240
        _sm_fix_0 = ConcurrencyContainer(outcomes=['fixed', 'failed', 'timed_out'], input_keys=['pose'], output_keys=['error_code', 'error_message'], conditions=[
                                        ('fixed', [('run', 'fixed')]),
                                        ('failed', [('run', 'failed')]),
                                        ('timed_out', [('timer', 'done')])
                                        ])

        with _sm_fix_0:
            # x:30 y:40
            OperatableStateMachine.add('run',
                                        FixCableState(),
                                        transitions={'fixed': 'fixed', 'failed': 'failed'},
                                        autonomy={'fixed': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'pose': 'pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:30 y:140
            OperatableStateMachine.add('timer',
                                        WaitState(wait_time=12.5),
                                        transitions={'done': 'timed_out'},
                                        autonomy={'done': Autonomy.High})


        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Locate_attempts',
                                        CountAttemptsState(attempts=3),
                                        transitions={'counted': 'Locate', 'exhausted': 'failed'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Off},
                                        remapping={'attempt': 'locate_attempts'})

            # x:1080 y:40
            OperatableStateMachine.add('Fix',
                                        _sm_fix_0,
                                        transitions={'fixed': 'finished', 'failed': 'Extract', 'timed_out': 'Extract'},
                                        autonomy={'fixed': Autonomy.Inherit, 'failed': Autonomy.Inherit, 'timed_out': Autonomy.Inherit},
                                        remapping={'pose': 'locate_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:830 y:40
            OperatableStateMachine.add('Insert',
                                        InsertCableState(force_limit_n=20),
                                        transitions={'inserted': 'Fix', 'failed': 'Extract'},
                                        autonomy={'inserted': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'pose': 'locate_pose', 'force': 'insert_force', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:580 y:40
            OperatableStateMachine.add('Insert_attempts',
                                        CountAttemptsState(attempts=3),
                                        transitions={'counted': 'Insert', 'exhausted': 'failed'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Off},
                                        remapping={'attempt': 'insert_attempts'})

            # x:280 y:40
            OperatableStateMachine.add('Locate',
                                        LocateComponentState(timeout_s=5.0),
                                        transitions={'located': 'Insert_attempts', 'failed': 'Locate_attempts'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'pose': 'locate_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1080 y:140
            OperatableStateMachine.add('Extract',
                                        ExtractCableState(timeout_s=20.0),
                                        transitions={'extracted': 'Locate_attempts', 'failed': 'failed'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Full},
                                        remapping={'cable_id': 'cable_id', 'error_code': 'error_code', 'error_message': 'error_message'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
