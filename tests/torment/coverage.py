#!/usr/bin/env python3
"""coverage.py BUILD: prints which part of the library the tests have run, file by file, and what
they have not: lines, and lines with a branch that was never taken.

BUILD holds objects made with --coverage and the counts of a run (make coverage). Functions that
were compiled several times (for several processors, or inline in several files) count as run where
one of their copies was. A line that carries the words "unreachable:" and a reason is left out.
Exit status 1 below 99.5 % of the lines or 95 % of the branches.
"""
import collections
import json
import pathlib
import subprocess
import sys

ROOMS = ["lcp", "vi", "reduction", "global", "src/base", "src/contact", "src/geometry", "src/linear", "src/files", "src/facts", "src/auto", "src/front", "src/motion"]
LINES, BRANCHES = 99.5, 95.0


def counts_of(build):
    """Returns {file: {line: [count, [count of each branch]]}}."""
    files = collections.defaultdict(dict)
    for room in ROOMS:
        for notes in sorted(pathlib.Path(build, "obj", room).rglob("*.gcno")):
            said = subprocess.run(["gcov", "--json-format", "--stdout", "-b", str(notes)],
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            for file in json.loads(said.stdout)["files"]:
                if not any(file["file"].startswith(r + "/") for r in ROOMS):
                    continue
                lines = files[file["file"]]
                for line in file["lines"]:
                    branches = [b["count"] for b in line["branches"]]
                    known = lines.setdefault(line["line_number"], [0, branches])
                    known[0] += line["count"]
                    if len(known[1]) == len(branches):
                        known[1] = [a + b for a, b in zip(known[1], branches)]
    return files


def numbers(lines):
    """Returns 3-5 7 for 3 4 5 7."""
    runs = []
    for line in lines:
        if runs and runs[-1][1] == line - 1:
            runs[-1][1] = line
        else:
            runs.append([line, line])
    return " ".join("%d" % a if a == b else "%d-%d" % (a, b) for a, b in runs)


def main():
    total = [0, 0, 0, 0]
    print("%7s %9s" % ("lines", "branches"))
    for file, lines in sorted(counts_of(sys.argv[1]).items()):
        text = [""] + pathlib.Path(file).read_text().splitlines()
        lines = {n: c for n, c in sorted(lines.items()) if "unreachable:" not in text[n]}
        branches = [b for _, own in lines.values() for b in own]
        own = [len(lines), sum(c[0] > 0 for c in lines.values()), len(branches), sum(b > 0 for b in branches)]
        total = [a + b for a, b in zip(total, own)]
        share = lambda part, whole: 100 * part / whole if whole else 100
        print("%7.2f %9.2f  %s" % (share(own[1], own[0]), share(own[3], own[2]), file))
        missed = [n for n, c in lines.items() if not c[0]]
        if missed:
            print("%19s lines %s" % ("", numbers(missed)))
        halves = [n for n, c in lines.items() if c[0] and not all(c[1])]
        if halves:
            print("%19s branches in %s" % ("", numbers(halves)))
    lines, branches = 100 * total[1] / total[0], 100 * total[3] / total[2]
    print("%7.2f %9.2f  of %d lines, %d branches" % (lines, branches, total[0], total[2]))
    return lines < LINES or branches < BRANCHES


if __name__ == "__main__":
    sys.exit(main())
