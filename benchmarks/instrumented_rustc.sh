#!/bin/sh
# The compiler as cargo calls it for crates of the workspace, with counters of which lines are reached.
exec "$@" -C instrument-coverage
