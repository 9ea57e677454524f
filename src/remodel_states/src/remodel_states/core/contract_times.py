"""The times of the contract between ability servers and their clients (remodel_msgs/README.md)."""

# [s] ROS time that a server has beyond a goal's timeout to report its end.
GRACE_S = 2.0

# [s] Wall time from a cancel to the goal's end.
CANCEL_LIMIT_S = 0.5

# [s] ROS time; a goal that takes longer reports its progress before it ends.
SILENT_LIMIT_S = 1.0

# [s] ROS time after which the client of a goal that was not taken has given up on the server.
LATE_S = 5.0

# [s] By which the clocks of a cell's machines may differ.
CLOCKS_DIFFER_S = 1.0
