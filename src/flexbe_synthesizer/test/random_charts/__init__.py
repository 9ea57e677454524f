"""Random charts, run on the engine and beside it by a reference that shares no code with it.

    generate    a seed -> chart files, valid ones and some whose data flow has holes; made of parts
                and of a data_flow
    chart_xml   chart files -> what they say, read with lxml
    reference   one run of a chart as the documentation describes it
    explore     all runs of a chart: is a value ever missing, or another's? is there a dead end?
    engine_run  chart files -> synthesized by the public path, run on flexbe_core
    judge       one seed or chart: do they agree?
    shrink      a chart on which they do not -> a small one
    packages    the states that such charts are made of

`python3 -m random_charts --help` runs seeds from the command line.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "packages" / "scripted_states" / "src"))
