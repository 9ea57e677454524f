"""What is uncertain, and what rehearsals say. No ROS, no files."""
