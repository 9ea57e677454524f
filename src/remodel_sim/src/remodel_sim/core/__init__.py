"""Pure values and rules: no physics engine, no ROS, no clock."""
