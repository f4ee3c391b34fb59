#!/bin/sh
# where.sh: prints date, commit and processor, which the head of a page names; bench/common.c prints them of a program's.
echo "$(date -u '+%d %B %Y'), commit $(git describe --always --dirty=' and changes' 2>/dev/null), $(grep -m 1 'model name' /proc/cpuinfo | sed 's/.*: //')"
