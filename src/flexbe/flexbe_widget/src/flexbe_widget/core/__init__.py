"""What start requests and statuses mean, without ROS."""
