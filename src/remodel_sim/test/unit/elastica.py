"""Reference solutions for thin elastic rods, to test the simulated wire against.

Heavy cantilever: clamped level at s = 0, free at s = L, EI phi'' = -w (L - s) cos(phi) with phi the
angle below the horizontal (Bickley 1934); solved by shooting on the clamp's curvature with
fourth-order Runge-Kutta.
"""

import math


def cantilever_drop(length, stiffness, weight, steps=400):
    """Return how far the tip of a heavy cantilever hangs below the clamp [m]."""
    load = weight * length**3 / stiffness
    low, high = 0.0, load
    for _ in range(60):
        middle = (low + high) / 2
        if _shoot(middle, load, steps)[0] > 0:
            high = middle
        else:
            low = middle
    return _shoot((low + high) / 2, load, steps)[1] * length


def _shoot(curvature, load, steps):
    """Integrate from the clamp.

    Return the curvature at the tip, and its drop, in units of the length.
    """
    h, angle, drop = 1.0 / steps, 0.0, 0.0

    def slope(s, phi):
        return -load * (1 - s) * math.cos(phi)

    for i in range(steps):
        s = i * h
        a1, k1 = curvature, slope(s, angle)
        a2, k2 = curvature + h / 2 * k1, slope(s + h / 2, angle + h / 2 * a1)
        a3, k3 = curvature + h / 2 * k2, slope(s + h / 2, angle + h / 2 * a2)
        a4, k4 = curvature + h * k3, slope(s + h, angle + h * a3)
        middle = angle + h / 2 * a2
        angle_next = angle + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        drop += h / 6 * (math.sin(angle) + 4 * math.sin(middle) + math.sin(angle_next))
        angle, curvature = angle_next, curvature + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return curvature, drop
