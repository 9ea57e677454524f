"""What hands do with a wire in its ducts: lead it, keep it there, and tuck it in."""
