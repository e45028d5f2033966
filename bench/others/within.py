"""Runs another program's command inside this process and keeps what it took, the interpreter's start and the imports left out.

python within.py MODULE:FUNCTION FIGURES.json ARGUMENTS...
"""

import json
import sys
import time
from importlib import import_module
from pathlib import Path

module, function = sys.argv[1].split(":")
figures = Path(sys.argv[2])
main = getattr(import_module(module), function)
sys.argv = [module, *sys.argv[3:]]
began, spent = time.perf_counter(), time.process_time()
try:
    main()
except SystemExit as end:
    if end.code:
        raise
figures.write_text(json.dumps({"seconds": time.perf_counter() - began, "cpu": time.process_time() - spent}))
