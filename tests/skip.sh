#!/bin/sh
# skip.sh WHAT: tells that a test does not run because this machine lacks a tool. Fails if NO_SKIP is set, as .ci/run does.
echo "skipped: $*"
[ -z "${NO_SKIP:-}" ]
