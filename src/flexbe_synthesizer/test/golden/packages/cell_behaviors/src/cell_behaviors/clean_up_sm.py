#!/usr/bin/env python
# -*- coding: utf-8 -*-
from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, PriorityContainer, Logger
from flexbe_states.user_data_state import UserDataState
from flexbe_states.wait_state import WaitState
# [MANUAL_IMPORT]

# [/MANUAL_IMPORT]


'''
Created on Mon Jan 01 2024
@author: somebody
'''
class CleanUpSM(Behavior):
	'''
	Put everything back.
	'''


	def __init__(self):
		super(CleanUpSM, self).__init__()
		self.name = 'Clean Up'

		# parameters of this behavior
		self.add_parameter('speed', 0.5)
		self.add_parameter('places', dict())

		# references to used behaviors

		# [MANUAL_INIT]

		# [/MANUAL_INIT]

		# Behavior comments:



	def create(self):
		# x:30 y:365, x:130 y:365
		_state_machine = OperatableStateMachine(outcomes=['cleaned', 'failed'], input_keys=['cable_id', 'thoroughness'], output_keys=['left_over'])
		_state_machine.userdata.cable_id = None
		_state_machine.userdata.thoroughness = 3
		_state_machine.userdata.left_over = None

		# [MANUAL_CREATE]

		# [/MANUAL_CREATE]


		with _state_machine:
			# x:30 y:40
			OperatableStateMachine.add('Wait',
										WaitState(wait_time=1),
										transitions={'done': 'Count'},
										autonomy={'done': Autonomy.Off})

			# x:230 y:40
			OperatableStateMachine.add('Count',
										UserDataState(data=self.places),
										transitions={'done': 'cleaned'},
										autonomy={'done': Autonomy.Off},
										remapping={'data': 'left_over'})


		return _state_machine


	# [MANUAL_FUNC]

	# [/MANUAL_FUNC]
