"""What the search works on, and what it finds.

tables       the problem as arrays of integers, as the kernel takes it
annealing    how much the search does at which temperature, for a limit of time
planned      a plan as the kernel returns it
"""
