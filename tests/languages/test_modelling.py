"""Runs the program of docs/modelling.md: its python blocks in order, by the line numbers of the page."""

import sys

program, inside, blocks = [], False, 0
with open("docs/modelling.md", encoding="utf-8") as page:
    for line in page:
        fence = line.startswith("```")
        if fence:
            inside = line.startswith("```python")
            blocks += inside
        program.append(line if inside and not fence else "\n")
if blocks < 8:
    sys.exit(f"docs/modelling.md has {blocks} blocks")
exec(compile("".join(program), "docs/modelling.md", "exec"), {})
