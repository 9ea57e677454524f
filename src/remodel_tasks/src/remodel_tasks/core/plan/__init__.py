"""Plans: checked, explained and drawn.

checker      the checker of plans, which shares no code with the search
explanation  a plan explained as text; drawing draws it
listing      a plan's wires in their order
"""
