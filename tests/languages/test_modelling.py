"""Runs the programs of docs/modelling.md and docs/statics.md: their python blocks in order, by the line numbers of the
page. Each block that solves asserts that it is solved, or that it is not."""

import re
import sys

for name, least in ("docs/modelling.md", 9), ("docs/statics.md", 6):
    program, inside, blocks = [], False, []
    with open(name, encoding="utf-8") as page:
        for line in page:
            fence = line.startswith("```")
            if fence:
                inside = line.startswith("```python")
                if inside:
                    blocks.append("")
            elif inside:
                blocks[-1] += line
            program.append(line if inside and not fence else "\n")
    if len(blocks) < least:
        sys.exit(f"{name} has {len(blocks)} blocks")
    for block in blocks:
        if re.search(r"^\S.*(solve\(|linkage\(|= (slope|arch)\()", block.split("def ")[0], re.M) and \
                not re.search(r"assert .*(solved|status)", block):
            sys.exit(f"{name}: a block does not assert that it is solved:\n{block}")
    exec(compile("".join(program), name, "exec"), {})
