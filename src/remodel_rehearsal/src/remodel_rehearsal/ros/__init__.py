"""What stands for ROS between the parts of one process: its messages, without its master."""
