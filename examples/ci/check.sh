#!/bin/sh
# Work a test log through, and fail where a run fails or the peak frequency leaves its tolerance.
#
#     sh check.sh TESTLOG REFERENCE [TOLERANCE] [OUT]
set -u
log=$1 reference=$2 tolerance=${3:-2 %} out=${4:-results}

shakerproc batch "$log" --out "$out" --no-figures
batch=$?
shakerproc check "$out" --against "$reference" --tolerance "$tolerance" --json "$out/check.json"
check=$?
[ "$batch" -eq 0 ] && [ "$check" -eq 0 ]
