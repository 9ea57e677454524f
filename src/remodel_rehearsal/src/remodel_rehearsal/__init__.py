"""Orders carried out in the simulated cell before the robot moves, many times, without ROS."""
