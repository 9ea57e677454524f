"""What charts name: the interfaces of states and behaviors, and charts joined with them."""
