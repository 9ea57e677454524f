"""What holds a wire, pulled until it slips: the grip against Coulomb, fixtures against orders."""

from __future__ import annotations

from collections.abc import Iterator

from holds import clamp_pull_out, clip_forces, grip_pull_out, spring_forces
from row import Row

RATES_HZ = (240.0, 500.0)
GRIPS_N = (10.0, 20.0, 30.0)
FRICTIONS = (0.3, 0.5)
RETENTIONS_N = (10.0, 40.0, 80.0)
# Retention [N] and diameter of the wire [m].
CLIPS = ((5.0, 0.003), (10.0, 0.003), (10.0, 0.006), (20.0, 0.006))


def rows() -> Iterator[Row]:
    """Measure; of each kind the worst."""
    for rate_hz in RATES_HZ:
        errors = []
        for grip in GRIPS_N:
            for friction in FRICTIONS:
                held, expected = grip_pull_out(grip, friction, rate_hz)
                errors.append(100 * abs(held / expected - 1))
        what = f"grip pull-out against 2 mu F, 10 to 30 N, worst of {len(errors)}, {rate_hz:g} Hz"
        yield Row(what, max(errors), "%", most=15.0)
        errors = [100 * abs(clamp_pull_out(f, rate_hz) / f - 1) for f in RETENTIONS_N]
        what = f"clamp pull-out against its retention, 10 to 80 N, worst, {rate_hz:g} Hz"
        yield Row(what, max(errors), "%", most=10.0)
        pairs = [(spring_forces(f / 4, f, rate_hz), f) for f in RETENTIONS_N]
        errors = [100 * abs(forces[0] / (f / 4) - 1) for forces, f in pairs]
        what = f"spring clamp against its insertion force, 2.5 to 20 N, worst, {rate_hz:g} Hz"
        yield Row(what, max(errors), "%", most=15.0)
        errors = [100 * abs(forces[1] / f - 1) for forces, f in pairs]
        what = f"spring clamp pull-out against its retention, 10 to 80 N, worst, {rate_hz:g} Hz"
        yield Row(what, max(errors), "%", most=10.0)
        errors = [100 * abs(clip_forces(f, d, rate_hz)[1] / f - 1) for f, d in CLIPS]
        what = f"clip pull-out against its retention, 5 to 20 N, worst, {rate_hz:g} Hz"
        yield Row(what, max(errors), "%", most=10.0)
