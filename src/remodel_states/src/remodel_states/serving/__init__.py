"""What the base of ability servers is made of: a goal, the robot, and who may command it."""
