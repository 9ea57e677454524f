"""The fields of goals, which are parameters of states too, that name the robots that do them."""

# An ability that takes two robots is given them in this order.
ROBOT_FIELDS = ("robot_name", "guide_name", "robot_1_name", "robot_2_name")
