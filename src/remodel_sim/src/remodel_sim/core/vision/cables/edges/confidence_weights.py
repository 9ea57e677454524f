"""Weights of the confidence, written by benchmarks/vision/fit_confidence.py."""

BIAS = 30.6239
WEIGHTS = {
    "contrast [log spreads]": 0.5715,
    "contrast [log levels]": -0.3743,
    "edges that agree": 8.9476,
    "sides alike": -0.0894,
    "length [log widths]": 2.4891,
    "spread of the width": -59.1561,
    "one hue": -79.2736,
    "one hue at the ends": 16.2115,
    "deep shadows": -6.0798,
    "halves of one hue": 10.8940,
    "softness [widths]": 6.6358,
    "softness [log px]": 0.2372,
    "margin": 5.3649,
    "goes on": -4.4961,
    "hidden ends": -7.4304,
    "truncated ends": 0.4984,
    "bend [log widths]": 0.2769,
    "end near another [widths]": 0.5791,
}
