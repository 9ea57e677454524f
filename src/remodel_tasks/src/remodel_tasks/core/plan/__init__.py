"""Plans: checked, explained and drawn.

checker      the checker of plans, which shares no code with the search
explanation  a plan explained as text, by its wires in their order; drawing draws it
"""
