"""Run many schedules, or show one.

python -m schedules --count 10000 --seed 0
python -m schedules --seed 4711 --count 1 --trace
"""

from __future__ import annotations

import argparse
import gc
import sys
import time

from schedules.schedule import Schedules


def main() -> int:
    """Run schedules, print failures with their seeds, and return 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="of schedules")
    parser.add_argument("--seed", type=int, default=0, help="of the first; the others follow it")
    parser.add_argument("--trace", action="store_true", help="print what happens in each")
    parser.add_argument("--failures", type=int, default=5, help="after which it ends")
    options = parser.parse_args()
    schedules = Schedules()
    gc.freeze()
    begun_s, failed, events, simulated_s = time.process_time(), 0, 0, 0.0
    done = 0
    for seed in range(options.seed, options.seed + options.count):
        verdict = schedules.run(seed, tracing=options.trace)
        done += 1
        events += verdict.events
        simulated_s += verdict.took_s
        if options.trace:
            sys.stdout.write("\n".join(verdict.trace) + "\n")
        if verdict.violation:
            failed += 1
            sys.stdout.write(f"seed {seed}: {verdict.violation}\n")
            sys.stdout.flush()
            if failed >= options.failures:
                break
    took_s = time.process_time() - begun_s
    sys.stdout.write(
        f"{done} schedules, {failed} failed; {events} events, {simulated_s / 3600:.1f} h simulated "
        f"in {took_s:.1f} s of one core: {60 * done / took_s:.0f} schedules a minute\n"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
