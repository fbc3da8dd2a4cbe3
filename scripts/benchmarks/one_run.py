"""One computation by the revision that PYTHONPATH names: prints its cost as JSON.

`python3 -P -m benchmarks.one_run CASE`, started by `benchmarks.compare`.
"""

import json
import os
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from benchmarks.compared_cases import CASES


def main() -> None:
    case = CASES[sys.argv[1]]
    answer = os.dup(1)
    os.dup2(2, 1)  # what a solver prints is no part of the answer
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.chdir(folder)
        case.rehearse(folder)
        cost = case.run(folder)
    with os.fdopen(answer, "w") as stream:
        json.dump(asdict(cost), stream)


if __name__ == "__main__":
    main()
