"""The topics of commands; relative names, as all of FlexBE's."""

COMMAND = "flexbe/uicommand"  # flexbe_msgs/UICommand
NOTIFICATION = "flexbe/uinotification"  # std_msgs/String: the command done, empty if refused
ANSWER = "flexbe/uianswer"  # std_msgs/String: in words, see core/answer.py
FEEDBACK = "flexbe/command_feedback"  # flexbe_msgs/CommandFeedback, from the engine
UPDATE = "flexbe/behavior_update"  # std_msgs/String: path of the state that is active
STATUS = "flexbe/status"  # flexbe_msgs/BEStatus, from the engine
ATTACH = "flexbe/command/attach"  # std_msgs/UInt8
LOCK = "flexbe/command/lock"  # std_msgs/String
UNLOCK = "flexbe/command/unlock"  # std_msgs/String
