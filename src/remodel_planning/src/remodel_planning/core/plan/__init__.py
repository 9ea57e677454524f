"""Plans: checked, explained, drawn, and continued.

checker      the checker of plans, which shares no code with the search
explanation  a plan explained as text; drawing draws it
listing      a plan's wires in their order
progress     the problem that is left when part of a plan is executed, and something has failed
"""
