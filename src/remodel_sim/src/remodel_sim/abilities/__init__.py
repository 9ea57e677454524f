"""What the robot can do, one file each: steps over a station."""
