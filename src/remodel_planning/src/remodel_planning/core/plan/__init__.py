"""Plans: judged, explained, drawn, and carried on.

checker      the judge of plans, which shares no code with the search
explanation  a plan in words; drawing draws it
listing      a plan's wires in their order
progress     the problem that is left when part of a plan is executed, and something has failed
"""
