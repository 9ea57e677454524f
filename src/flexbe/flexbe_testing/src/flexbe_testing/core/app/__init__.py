"""The FlexBE App's rules: how it reads states and behaviors.

The App reads files by patterns, not as Python, so a file that runs may still lose parts there.
Pure Python: texts in, complaints out; `edge` reads the packages.

Written from observations of the running App, version 2.3.0. Where they leave room, the stricter
reading is taken.
"""
