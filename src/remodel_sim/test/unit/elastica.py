"""Reference solutions for thin elastic rods, to test the simulated wire against.

Independent of the simulation: the rod's own differential equations, solved by shooting, and a
closed form.
"""

import math


def cantilever_drop(length, stiffness, weight, steps=1000):
    """Return how far the tip of a heavy cantilever hangs below the clamp [m].

    Weight per length [N/m].
    """
    _, drops = cantilever_shape(weight * length**3 / stiffness, steps)
    return drops[-1] * length


def cantilever_shape(load, steps=1000):
    """Return how far out, and how far down, the points of a heavy cantilever are, over its length.

    Clamped level at s = 0, free at s = L: EI phi'' = -w (L - s) cos(phi), phi the angle below the
    horizontal (W. G. Bickley, The heavy elastica, Phil. Mag. 17, 1934). Solved by bisection on the
    curvature at the clamp, with fourth-order Runge-Kutta; load is w L^3 / EI.
    """
    low, high = 0.0, load
    for _ in range(60):
        middle = (low + high) / 2
        if _shoot(middle, load, steps)[0] > 0:
            high = middle
        else:
            low = middle
    _, xs, drops = _shoot((low + high) / 2, load, steps)
    return xs, drops


def _shoot(curvature, load, steps):
    """Integrate from the clamp.

    Return the curvature at the tip, and how far out and down every point is, over the length.
    """
    h, angle, xs, drops = 1.0 / steps, 0.0, [0.0], [0.0]

    def slope(s, phi):
        return -load * (1 - s) * math.cos(phi)

    for i in range(steps):
        s = i * h
        a1, k1 = curvature, slope(s, angle)
        a2, k2 = curvature + h / 2 * k1, slope(s + h / 2, angle + h / 2 * a1)
        a3, k3 = curvature + h / 2 * k2, slope(s + h / 2, angle + h / 2 * a2)
        a4, k4 = curvature + h * k3, slope(s + h, angle + h * a3)
        middle = angle + h / 2 * a2
        end = angle + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        xs.append(xs[-1] + h / 6 * (math.cos(angle) + 4 * math.cos(middle) + math.cos(end)))
        drops.append(drops[-1] + h / 6 * (math.sin(angle) + 4 * math.sin(middle) + math.sin(end)))
        angle, curvature = end, curvature + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return curvature, xs, drops


def buckling_load(length, stiffness):
    """Return Euler's load of a rod clamped at one end and free at the other [N]."""
    return math.pi**2 * stiffness / (4 * length**2)


def buckled_tip_angle(ratio):
    """Return the angle of the free tip under `ratio` times Euler's load, kept in direction [rad].

    P / Pcr = (2 K(sin(a / 2)) / pi)^2, K the complete elliptic integral of the first kind
    (S. Timoshenko and J. Gere, Theory of Elastic Stability, 2.7).
    """
    if ratio <= 1.0:
        return 0.0
    low, high = 0.0, 0.999 * math.pi
    for _ in range(100):
        middle = (low + high) / 2
        if (2 * _complete_elliptic(math.sin(middle / 2)) / math.pi) ** 2 < ratio:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _complete_elliptic(modulus):
    """Return K(k) by the arithmetic-geometric mean."""
    a, b = 1.0, math.sqrt(1.0 - modulus**2)
    while a - b > 1e-15:
        a, b = (a + b) / 2, math.sqrt(a * b)
    return math.pi / (2 * a)
