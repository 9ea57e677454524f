#!/usr/bin/env python3
# -*- coding: utf-8 -*-
###########################################################
#        Generated from a state chart: do not edit        #
#                                                         #
#  Change the chart and synthesize it again.              #
#  Only the code between [MANUAL] tags is kept then.      #
###########################################################

from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from flexbe_states.decision_state import DecisionState
from remodel_states.count_attempts_state import CountAttemptsState
from remodel_states.extract_cable_state import ExtractCableState
from remodel_states.fix_cable_state import FixCableState
from remodel_states.insert_cable_state import InsertCableState
from remodel_states.locate_gearbox_component_state import LocateGearboxComponentState
# Imports of your own belong between these tags.
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on undated
@author: REMODEL planner developers
'''
class PlaceConnectorSM(Behavior):
    '''
    Places one end of a wire in a terminal: Figure 3 of Deliverable 5.1. A failed insertion or fixing pulls the end
    out and locates the component again, at most three times. What neither action nor behavior is to handle first
    (remodel_msgs/config/faults.yaml) fails at once. A push that jams, or needs more force, is not repeated
    here: the end is withdrawn, and the supervisor decides.
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
        # x:1580 y:40, x:1580 y:140
        _state_machine = OperatableStateMachine(outcomes=['finished', 'failed'], input_keys=['cable_id', 'cable_end', 'component_id', 'terminal_id'], output_keys=['error_code', 'error_message'])
        _state_machine.userdata.cable_id = 'W1'
        _state_machine.userdata.cable_end = 'a'
        _state_machine.userdata.component_id = 'X1'
        _state_machine.userdata.terminal_id = '1'
        _state_machine.userdata.error_code = None
        _state_machine.userdata.error_message = None
        _state_machine.userdata.locate_gearbox_component_attempts = 0

        # Creation code of your own belongs between these tags.
        # [MANUAL_CREATE]

        # [/MANUAL_CREATE]

        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('LocateGearboxComponent_attempts',
                                        CountAttemptsState(attempts=3),
                                        transitions={'counted': 'LocateGearboxComponent', 'exhausted': 'failed'},
                                        autonomy={'counted': Autonomy.Off, 'exhausted': Autonomy.Off},
                                        remapping={'attempt': 'locate_gearbox_component_attempts'})

            # x:1080 y:40
            OperatableStateMachine.add('FixCable',
                                        FixCableState(timeout_s=20.0),
                                        transitions={'fixed': 'finished', 'failed': 'FixCable_error', 'command_error': 'failed'},
                                        autonomy={'fixed': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1330 y:40
            OperatableStateMachine.add('FixCable_error',
                                        DecisionState(outcomes=['failed_NOT_SEATED', 'failed_INSUFFICIENT_FORCE', 'failed_above_behavior', 'other'], conditions=lambda code: 'failed_NOT_SEATED' if code in range(304, 305) else 'failed_INSUFFICIENT_FORCE' if code in range(308, 309) else 'failed_above_behavior' if code in (3, 4, 5, 7, 8, 9, 10, 102, 103, 110, 111, 115, 203, 204, 301, 306, 307, 309, 310, 311, 400, 401, 402, 403, 405) else 'other'),
                                        transitions={'failed_NOT_SEATED': 'WithdrawCable', 'failed_INSUFFICIENT_FORCE': 'WithdrawCable', 'failed_above_behavior': 'failed', 'other': 'ExtractCable'},
                                        autonomy={'failed_NOT_SEATED': Autonomy.Off, 'failed_INSUFFICIENT_FORCE': Autonomy.Off, 'failed_above_behavior': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:730 y:40
            OperatableStateMachine.add('InsertCable',
                                        InsertCableState(timeout_s=60.0),
                                        transitions={'inserted': 'FixCable', 'failed': 'InsertCable_error', 'command_error': 'failed'},
                                        autonomy={'inserted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'cable_end': 'cable_end', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'depth': 'insert_cable_depth', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1080 y:140
            OperatableStateMachine.add('InsertCable_error',
                                        DecisionState(outcomes=['failed_INSERTION_JAMMED', 'failed_NOT_SEATED', 'failed_INSUFFICIENT_FORCE', 'failed_above_behavior', 'other'], conditions=lambda code: 'failed_INSERTION_JAMMED' if code in range(301, 302) else 'failed_NOT_SEATED' if code in range(304, 305) else 'failed_INSUFFICIENT_FORCE' if code in range(308, 309) else 'failed_above_behavior' if code in (3, 4, 5, 7, 8, 9, 10, 102, 103, 110, 111, 115, 203, 204, 306, 307, 309, 310, 311, 400, 401, 402, 403, 405) else 'other'),
                                        transitions={'failed_INSERTION_JAMMED': 'WithdrawCable', 'failed_NOT_SEATED': 'WithdrawCable', 'failed_INSUFFICIENT_FORCE': 'WithdrawCable', 'failed_above_behavior': 'failed', 'other': 'ExtractCable'},
                                        autonomy={'failed_INSERTION_JAMMED': Autonomy.Off, 'failed_NOT_SEATED': Autonomy.Off, 'failed_INSUFFICIENT_FORCE': Autonomy.Off, 'failed_above_behavior': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:380 y:40
            OperatableStateMachine.add('LocateGearboxComponent',
                                        LocateGearboxComponentState(timeout_s=30.0),
                                        transitions={'located': 'InsertCable', 'failed': 'LocateGearboxComponent_error', 'command_error': 'failed'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'terminal_id': 'terminal_id', 'component_pose': 'locate_gearbox_component_component_pose', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:730 y:140
            OperatableStateMachine.add('LocateGearboxComponent_error',
                                        DecisionState(outcomes=['failed_above_behavior', 'other'], conditions=lambda code: 'failed_above_behavior' if code in (3, 4, 5, 7, 8, 9, 10, 102, 103, 110, 111, 115, 203, 204, 301, 304, 306, 307, 308, 309, 310, 311, 400, 401, 402, 403, 405) else 'other'),
                                        transitions={'failed_above_behavior': 'failed', 'other': 'LocateGearboxComponent_attempts'},
                                        autonomy={'failed_above_behavior': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:1330 y:140
            OperatableStateMachine.add('WithdrawCable',
                                        ExtractCableState(timeout_s=30.0),
                                        transitions={'extracted': 'failed', 'failed': 'failed', 'command_error': 'failed'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1330 y:240
            OperatableStateMachine.add('ExtractCable',
                                        ExtractCableState(timeout_s=30.0),
                                        transitions={'extracted': 'LocateGearboxComponent_attempts', 'failed': 'failed', 'command_error': 'failed'},
                                        autonomy={'extracted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})


        return _state_machine


    # Functions of your own belong between these tags.
    # [MANUAL_FUNC]

    # [/MANUAL_FUNC]
