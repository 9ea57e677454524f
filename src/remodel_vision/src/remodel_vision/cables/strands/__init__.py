"""From a picture to strands: foreground, skeleton, and strands joined into rough cables."""
