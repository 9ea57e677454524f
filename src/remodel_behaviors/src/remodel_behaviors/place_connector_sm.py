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
    (remodel_msgs/config/faults.yaml) fails at once. A push that jams, or needs more force (301, 304, 308), is not
    repeated here: the end is withdrawn, and the supervisor decides.
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
                                        DecisionState(outcomes=['failed 3-5', 'failed 7-10', 'failed 203-204', 'failed 304', 'failed 306-307', 'failed 308', 'failed 400-403', 'failed 405', 'other'], conditions=lambda code: 'failed 3-5' if code in range(3, 6) else 'failed 7-10' if code in range(7, 11) else 'failed 203-204' if code in range(203, 205) else 'failed 304' if code in range(304, 305) else 'failed 306-307' if code in range(306, 308) else 'failed 308' if code in range(308, 309) else 'failed 400-403' if code in range(400, 404) else 'failed 405' if code in range(405, 406) else 'other'),
                                        transitions={'failed 3-5': 'failed', 'failed 7-10': 'failed', 'failed 203-204': 'failed', 'failed 304': 'WithdrawCable', 'failed 306-307': 'failed', 'failed 308': 'WithdrawCable', 'failed 400-403': 'failed', 'failed 405': 'failed', 'other': 'ExtractCable'},
                                        autonomy={'failed 3-5': Autonomy.Off, 'failed 7-10': Autonomy.Off, 'failed 203-204': Autonomy.Off, 'failed 304': Autonomy.Off, 'failed 306-307': Autonomy.Off, 'failed 308': Autonomy.Off, 'failed 400-403': Autonomy.Off, 'failed 405': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:730 y:40
            OperatableStateMachine.add('InsertCable',
                                        InsertCableState(timeout_s=60.0),
                                        transitions={'inserted': 'FixCable', 'failed': 'InsertCable_error', 'command_error': 'failed'},
                                        autonomy={'inserted': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'cable_id': 'cable_id', 'cable_end': 'cable_end', 'component_id': 'component_id', 'terminal_id': 'terminal_id', 'socket_pose': 'locate_gearbox_component_socket_pose', 'depth': 'insert_cable_depth', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:1080 y:140
            OperatableStateMachine.add('InsertCable_error',
                                        DecisionState(outcomes=['failed 3-5', 'failed 7-10', 'failed 110-111', 'failed 115', 'failed 203-204', 'failed 301', 'failed 304', 'failed 306-307', 'failed 308', 'failed 400-403', 'failed 405', 'other'], conditions=lambda code: 'failed 3-5' if code in range(3, 6) else 'failed 7-10' if code in range(7, 11) else 'failed 110-111' if code in range(110, 112) else 'failed 115' if code in range(115, 116) else 'failed 203-204' if code in range(203, 205) else 'failed 301' if code in range(301, 302) else 'failed 304' if code in range(304, 305) else 'failed 306-307' if code in range(306, 308) else 'failed 308' if code in range(308, 309) else 'failed 400-403' if code in range(400, 404) else 'failed 405' if code in range(405, 406) else 'other'),
                                        transitions={'failed 3-5': 'failed', 'failed 7-10': 'failed', 'failed 110-111': 'failed', 'failed 115': 'failed', 'failed 203-204': 'failed', 'failed 301': 'WithdrawCable', 'failed 304': 'WithdrawCable', 'failed 306-307': 'failed', 'failed 308': 'WithdrawCable', 'failed 400-403': 'failed', 'failed 405': 'failed', 'other': 'ExtractCable'},
                                        autonomy={'failed 3-5': Autonomy.Off, 'failed 7-10': Autonomy.Off, 'failed 110-111': Autonomy.Off, 'failed 115': Autonomy.Off, 'failed 203-204': Autonomy.Off, 'failed 301': Autonomy.Off, 'failed 304': Autonomy.Off, 'failed 306-307': Autonomy.Off, 'failed 308': Autonomy.Off, 'failed 400-403': Autonomy.Off, 'failed 405': Autonomy.Off, 'other': Autonomy.Off},
                                        remapping={'input_value': 'error_code'})

            # x:380 y:40
            OperatableStateMachine.add('LocateGearboxComponent',
                                        LocateGearboxComponentState(timeout_s=30.0),
                                        transitions={'located': 'InsertCable', 'failed': 'LocateGearboxComponent_error', 'command_error': 'failed'},
                                        autonomy={'located': Autonomy.Off, 'failed': Autonomy.Off, 'command_error': Autonomy.Off},
                                        remapping={'component_id': 'component_id', 'terminal_id': 'terminal_id', 'component_pose': 'locate_gearbox_component_component_pose', 'socket_pose': 'locate_gearbox_component_socket_pose', 'error_code': 'error_code', 'error_message': 'error_message'})

            # x:730 y:140
            OperatableStateMachine.add('LocateGearboxComponent_error',
                                        DecisionState(outcomes=['failed 3-5', 'failed 7-10', 'failed 102-103', 'failed 400-403', 'failed 405', 'other'], conditions=lambda code: 'failed 3-5' if code in range(3, 6) else 'failed 7-10' if code in range(7, 11) else 'failed 102-103' if code in range(102, 104) else 'failed 400-403' if code in range(400, 404) else 'failed 405' if code in range(405, 406) else 'other'),
                                        transitions={'failed 3-5': 'failed', 'failed 7-10': 'failed', 'failed 102-103': 'failed', 'failed 400-403': 'failed', 'failed 405': 'failed', 'other': 'LocateGearboxComponent_attempts'},
                                        autonomy={'failed 3-5': Autonomy.Off, 'failed 7-10': Autonomy.Off, 'failed 102-103': Autonomy.Off, 'failed 400-403': Autonomy.Off, 'failed 405': Autonomy.Off, 'other': Autonomy.Off},
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
