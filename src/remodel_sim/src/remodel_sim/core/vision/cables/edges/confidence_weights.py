"""Weights of the confidence, written by benchmarks/vision/fit_confidence.py."""

BIAS = 34.9040
WEIGHTS = {
    "contrast [log spreads]": -0.2987,
    "contrast [log levels]": 0.2143,
    "edges that agree": 8.8572,
    "sides alike": -3.6305,
    "length [log widths]": 2.0818,
    "spread of the width": -78.8073,
    "one hue": -66.2495,
    "one hue at the ends": 11.2769,
    "deep shadows": -3.8926,
    "halves of one hue": 4.1239,
    "overexposed beside": 0.8202,
    "softness [widths]": 1.5905,
    "softness [log px]": 0.9765,
    "margin": 6.1717,
    "over foreign objects": 2.6136,
    "goes on": -6.1192,
    "hidden ends": -8.9719,
    "truncated ends": 0.1603,
    "bend [log widths]": 0.7018,
    "end near another [widths]": 0.4986,
}
