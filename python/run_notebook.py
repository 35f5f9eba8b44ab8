"""Runs the code of a notebook in one process: python run_notebook.py FILE"""

import json
import sys
from pathlib import Path

place: dict = {"__name__": "__main__"}
for number, cell in enumerate(json.loads(Path(sys.argv[1]).read_text())["cells"]):
    if cell["cell_type"] == "code":
        exec(compile("".join(cell["source"]), f"cell {number}", "exec"), place)
print("notebook done")
