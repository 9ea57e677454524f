"""What is to be done: components, terminals and tasks, without durations.

work_order   an order of a use case; order_format says which documents are one
board_order  a board as an order: wires, or (branch_order) branches, in its surroundings
"""
