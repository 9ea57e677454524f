"""What a start request says, read without ROS."""
