"""What several tests of the synthesizer share.

chart_run                 what a chart of our own model means: one run
classes                   state classes of libraries that tests make up
rendering                 the file that a behavior becomes
strategies                charts of any shape, drawn by Hypothesis
w3c_scxml                 the rules of W3C SCXML that charts can break
"""
